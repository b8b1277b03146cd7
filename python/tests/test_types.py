"""Every function says what it takes and gives: mypy's strict rules hold in the package, its example and its tests."""
from __future__ import annotations

import importlib.util
import pathlib
import subprocess
import sys
import unittest

PYTHON = pathlib.Path(__file__).resolve().parents[1]


class Types(unittest.TestCase):
    def test_strict(self) -> None:
        if importlib.util.find_spec("mypy") is None:
            self.skipTest("mypy is not installed")
        result = subprocess.run(
            [sys.executable, "-m", "mypy", "--no-incremental", "--config-file", PYTHON / "pyproject.toml", *(name for name in ("src", "examples", "tests") if (PYTHON / name).exists()),
             "--exclude", "run.py"],
            cwd=PYTHON, capture_output=True, text=True, timeout=600, env={"MYPYPATH": f"{PYTHON}/src:{PYTHON}/tests"})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
