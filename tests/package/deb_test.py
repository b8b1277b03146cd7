#!/usr/bin/env python3
"""The Debian packages: what they say, what they hold, and the program out of one of them on a small capture.

    deb_test.py BUILD REPOSITORY

Whether they install on a bare system is for scripts/test_package.sh, which takes minutes and a network.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
REPOSITORY = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(REPOSITORY / "tests" / "end_to_end"))
import captures  # noqa: E402


def output(*command, **options):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=900, **options)
    assert result.returncode == 0, f"{command}: exit code {result.returncode}\n{result.stdout}\n{result.stderr}"
    return result.stdout


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temp = tempfile.TemporaryDirectory(prefix="deepslam-deb-")
        cls.folder = pathlib.Path(cls.temp.name)
        output("cpack", "--config", BUILD / "CPackConfig.cmake", "-G", "DEB", "-B", cls.folder, cwd=cls.folder)
        cls.program, = cls.folder.glob("deepslam_*.deb")
        cls.libraries, = cls.folder.glob("deepslam-dev_*.deb")
        cls.root = cls.folder / "root"
        output("dpkg-deb", "-x", cls.program, cls.root)

    @classmethod
    def tearDownClass(cls):
        cls.temp.cleanup()

    def field(self, package, name):
        return output("dpkg-deb", "-f", package, name).strip()

    def test_every_library_that_is_linked_is_a_dependency_or_comes_along(self):
        depends = re.split(r"[ ,|()]+", self.field(self.program, "Depends"))
        needed = []
        for name in ("bin/deepslam", "lib/deepslam/libdeepslam_video.so"):
            needed += re.findall(r"NEEDED.*\[(.*)\]", output("readelf", "-d", self.root / "usr" / name))
        self.assertGreater(len(needed), 15)
        self.assertIn("libopencv_videoio", " ".join(needed))
        for name in needed:
            if (self.root / "usr/lib/deepslam" / name).is_file():
                continue
            owners = subprocess.run(["dpkg", "-S", f"*/{name}"], capture_output=True, text=True).stdout
            packages = {line.split(":")[0] for line in owners.splitlines()}
            for package in sorted(packages):
                provided = output("dpkg-query", "-W", "-f", "${Provides}", package)
                packages |= {word.split()[0] for word in provided.split(",") if word.strip()}
            self.assertTrue(packages & set(depends), f"{name} is of {packages}, the package depends on {depends}")
        self.assertFalse([name for name in depends if name.endswith("-dev")], "the program needs no headers")
        self.assertEqual(self.field(self.program, "Architecture"), "amd64")

    def test_the_libraries_go_with_their_program(self):
        version = self.field(self.program, "Version")
        depends = self.field(self.libraries, "Depends")
        self.assertIn(f"deepslam (= {version})", depends)
        # Every package that deepslamConfig.cmake looks for comes with one of these.
        for name in ("libopencv-dev", "libceres-dev", "libcgal-dev", "libopen3d-dev", "libembree-dev", "libzip-dev"):
            self.assertIn(name, depends)
        files = output("dpkg-deb", "-c", self.libraries)
        self.assertIn("./usr/lib/cmake/deepslam/deepslamConfig.cmake", files)
        self.assertIn("./usr/lib/libdeepslam_core.a", files)

    def test_nothing_twice_nothing_foreign_nothing_of_this_machine(self):
        def listed(package):
            lines = [line.split(None, 5) for line in output("dpkg-deb", "-c", package).splitlines()]
            for line in lines:
                self.assertEqual(line[1], "root/root")
                self.assertNotRegex(line[0], r"^-.......w", "writable by all")
            return {line[5].split(" -> ")[0] for line in lines if line[0][0] != "d"}
        program, libraries = listed(self.program), listed(self.libraries)
        self.assertFalse(program & libraries)
        for name in program | libraries:
            self.assertTrue(name.startswith("./usr/"), name)
            if not name.startswith("./usr/share/deepslam/configs/priors/"):  # ours
                self.assertNotRegex(name, r"\.(onnx|pt|sh3f|obj)$", "weights and furniture are in no package")

    def test_licences_are_there(self):
        text = (self.root / "usr/share/doc/deepslam/copyright").read_text()
        for part in ("BSD 3-Clause", "GPL-3.0-or-later", "==== ONNX Runtime", "==== three.js", "Microsoft Corporation"):
            self.assertIn(part, text)

    def test_the_program_works_where_it_was_unpacked(self):
        home = self.folder / "home"
        home.mkdir()
        environment = {"HOME": str(home), "PATH": f"{self.root}/usr/bin:/usr/bin:/bin"}
        # The sample's own script, on a smaller scene and without what has to be fetched.
        self.assertIn("--downloads", output("deepslam-demo", "--help", env=environment))
        if not pathlib.Path("/usr/share/sweethome3d/furniture").is_dir():
            self.skipTest("needs sweethome3d-furniture: scripts/setup.sh")
        (self.folder / "scene.yaml").write_text(captures.SCENE)
        output("deepslam", "synth", "scene.yaml", "-o", "capture", env=environment, cwd=self.folder)
        output("deepslam", "run", "capture", "-o", "workspace", "--until", "ground", *captures.BARE, env=environment,
               cwd=self.folder)
        self.assertTrue((self.folder / "workspace/ground/ground.json").is_file())


if __name__ == "__main__":
    missing = [name for name in ("cpack", "dpkg-deb", "dpkg-shlibdeps", "readelf") if shutil.which(name) is None]
    if missing:
        print(f"needs {', '.join(missing)}: skipped", file=sys.stderr)
        sys.exit(77)
    os.umask(0o022)
    unittest.main()
