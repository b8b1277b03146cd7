"""The package as pip installs it, and the files that have to agree with it."""
from __future__ import annotations

import importlib.util
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest
import zipfile

import deepslam
from deepslam import compact_map, layout, relations

PYTHON = pathlib.Path(__file__).resolve().parents[1]
REPOSITORY = PYTHON.parent


class Package(unittest.TestCase):
    def test_versions_and_licences_agree(self) -> None:
        project = tomllib.loads((PYTHON / "pyproject.toml").read_text())["project"]
        of_program = re.search(r"project\(deepslam VERSION (\S+)", (REPOSITORY / "CMakeLists.txt").read_text())
        assert of_program
        self.assertEqual({project["version"], deepslam.__version__}, {of_program[1]})
        self.assertEqual((PYTHON / "LICENSE").read_text(), (REPOSITORY / "LICENSE").read_text())
        self.assertEqual(project["license"], "BSD-3-Clause")
        self.assertEqual([re.split(r"[<>=]", name)[0] for name in project["dependencies"]], ["numpy"])

    def test_the_wheel_holds_all_and_is_installed(self) -> None:
        if importlib.util.find_spec("hatchling") is None:
            self.skipTest("hatchling is not installed")
        with tempfile.TemporaryDirectory(prefix="deepslam-python-") as name:
            folder = pathlib.Path(name)
            shutil.copytree(PYTHON, folder / "python", ignore=shutil.ignore_patterns("__pycache__", "tests"))
            # What `pip install ./python` does, but for fetching the backend and numpy.
            pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
            built = subprocess.run([*pip, "wheel", "--no-deps", "--no-build-isolation", "--no-index", "-w", folder, folder / "python"],
                                   capture_output=True, text=True, timeout=300)
            self.assertEqual(built.returncode, 0, built.stderr)
            wheel = next(folder.glob("*.whl"))
            self.assertEqual(wheel.name, f"deepslam-{deepslam.__version__}-py3-none-any.whl")
            sources = {f"deepslam/{file.name}" for file in (PYTHON / "src/deepslam").iterdir() if file.suffix in (".py", ".typed")}
            names = set(zipfile.ZipFile(wheel).namelist())
            self.assertEqual({file for file in names if file.startswith("deepslam/")}, sources)
            self.assertTrue(any(file.endswith("licenses/LICENSE") for file in names), names)
            installed = subprocess.run([*pip, "install", "--no-deps", "--no-index", "--target", folder / "there", wheel],
                                       capture_output=True, text=True, timeout=300)
            self.assertEqual(installed.returncode, 0, installed.stderr)
            told = subprocess.run([sys.executable, "-c", "import deepslam; print(deepslam.__file__)"], capture_output=True, text=True,
                                  env={"PYTHONPATH": str(folder / "there")}, cwd=folder, timeout=60)
            self.assertEqual(told.stdout.strip(), str(folder / "there/deepslam/__init__.py"), told.stderr)

    def test_the_page_says_what_the_docstrings_do(self) -> None:
        script = REPOSITORY / "scripts" / "python_docs.py"
        result = subprocess.run([sys.executable, "-B", script, "--check"], capture_output=True, text=True, timeout=60)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_the_schema_knows_the_same_words(self) -> None:
        schema = json.loads((REPOSITORY / "docs/scene_graph.schema.json").read_text())
        parts = schema["$defs"]
        self.assertEqual(list(relations.PREDICATES), parts["relation"]["properties"]["predicate"]["enum"])
        self.assertEqual(list(layout.KINDS), parts["opening"]["properties"]["kind"]["enum"])
        self.assertEqual(list(compact_map.VERDICTS), schema["properties"]["verdict"]["enum"])
        self.assertEqual(schema["properties"]["version"]["const"], 1)

    def test_numpy_alone_is_needed(self) -> None:
        """Extras are imported where they are used."""
        program = ("import sys\nfor name in ('trimesh', 'rerun', 'matplotlib'): sys.modules[name] = None\n"
                   "import deepslam, deepslam.glb, deepslam.rerun_recording\nprint(len(deepslam.__all__))")
        result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60,
                                env={"PYTHONPATH": str(PYTHON / "src")})
        self.assertEqual(result.returncode, 0, result.stderr)
