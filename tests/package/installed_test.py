#!/usr/bin/env python3
"""`cmake --install` into a folder that is moved afterwards: the program runs there, and a project of its own finds the
libraries by find_package.

    installed_test.py BUILD REPOSITORY
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


def run(*command, code=0, **options):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=900, **options)
    assert result.returncode == code, f"{command}: exit code {result.returncode}\n{result.stdout}\n{result.stderr}"
    return result


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temp = tempfile.TemporaryDirectory(prefix="deepslam-install-")
        cls.folder = pathlib.Path(cls.temp.name)
        run("cmake", "--install", BUILD, "--prefix", cls.folder / "first")
        cls.prefix = cls.folder / "second place"
        (cls.folder / "first").rename(cls.prefix)
        cls.home = cls.folder / "home"
        cls.home.mkdir()
        cls.program = cls.prefix / "bin" / "deepslam"
        # Nothing of this user, neither data nor libraries.
        cls.environment = {"HOME": str(cls.home), "PATH": f"{cls.prefix}/bin:/usr/bin:/bin"}

    @classmethod
    def tearDownClass(cls):
        cls.temp.cleanup()

    def test_program_needs_nothing_of_the_build(self):
        dynamic = run("readelf", "-d", self.program).stdout
        self.assertRegex(dynamic, r"RUNPATH.*\[\$ORIGIN/\.\./lib/deepslam\]")
        libraries = run("ldd", self.program, env=self.environment).stdout
        self.assertNotIn("not found", libraries)
        self.assertRegex(libraries, rf"libonnxruntime.so.1 => {re.escape(str(self.prefix))}/bin/\.\./lib/deepslam/")
        for path in self.prefix.rglob("*"):
            if path.is_file() and path.suffix in (".cmake", ".sh", ".1"):
                self.assertNotIn(str(REPOSITORY).encode(), path.read_bytes(), path)

    def test_a_capture_goes_through(self):
        scene = self.folder / "scene.yaml"
        scene.write_text(captures.SCENE)
        made = subprocess.run(["deepslam", "synth", scene, "-o", "capture"], cwd=self.folder, env=self.environment,
                              capture_output=True, text=True)
        if made.returncode == 3 and "sweethome3d-furniture" in made.stderr:
            self.skipTest("needs sweethome3d-furniture: scripts/setup.sh")
        self.assertEqual(made.returncode, 0, made.stderr)
        without = run("deepslam", "run", "capture", "-o", "none", code=3, cwd=self.folder, env=self.environment)
        self.assertIn("deepslam-fetch-weights", without.stderr)
        run("deepslam", "run", "capture", "-o", "workspace", "--progress", "none", *captures.BARE, cwd=self.folder,
            env=self.environment)
        for name in ("export/scene.glb", "export/map.json", "report/index.html"):
            self.assertGreater((self.folder / "workspace" / name).stat().st_size, 500, name)
        # The network's library is ours: it must load where it lies.
        weights = self.home / ".local/share/deepslam/weights"
        weights.mkdir(parents=True)
        (weights / "yolov8s.onnx").write_bytes(b"no network")
        broken = run("deepslam", "run", "capture", "-o", "network", "--set", "propose.retrieval=false", code=3,
                     cwd=self.folder, env=self.environment)
        self.assertIn("not a network that can be run", broken.stderr)

    def test_videos_are_read_by_the_module_that_came_along(self):
        capture = self.folder / "phone"
        (capture / "depth").mkdir(parents=True)
        (capture / "rgb.mp4").write_text("no video")
        captures.write_depth(capture / "depth" / "000000.png", 64, 48, 1500)
        (capture / "odometry.csv").write_text("timestamp, frame, x, y, z, qx, qy, qz, qw\n0.1, 000000, 0, 0, 0, 0, 0, 0, 1\n")
        (capture / "camera_matrix.csv").write_text("60, 0, 31.5\n0, 60, 23.5\n0, 0, 1\n")
        call = ("deepslam", "run", capture, "-o", self.folder / "phone_workspace", "--until", "track")
        self.assertIn("not a video", run(*call, code=3, env=self.environment).stderr)
        module = self.prefix / "lib/deepslam/libdeepslam_video.so"
        aside = module.rename(self.folder / "module")
        try:
            told = run(*call, code=1, env=self.environment).stderr
        finally:
            aside.rename(module)
        for part in ("rgb.mp4", "videos need libdeepslam_video.so", "No such file", "install deepslam anew"):
            self.assertIn(part, told)

    def test_data_folder_beside_the_program(self):
        def data_folder():
            told = subprocess.run(["deepslam", "doctor"], capture_output=True, text=True, env=self.environment, cwd=self.folder)
            return re.search(r"data folder +(.*)", told.stderr)[1]
        self.assertEqual(data_folder(), str(self.home / ".local/share/deepslam"))
        beside = self.prefix / "share/deepslam/weights"
        beside.mkdir()
        self.assertEqual(data_folder(), str(beside.parent))
        beside.rmdir()

    def test_withheld_products_are_those_of_the_installed_list(self):
        if not pathlib.Path("/usr/share/sweethome3d/furniture").is_dir():
            self.skipTest("needs sweethome3d-furniture: scripts/setup.sh")
        listed = self.prefix / "share/deepslam/configs/withheld_models.yaml"
        kept = listed.read_text()
        try:
            listed.write_text("withheld:\n  - id: unquoted\n")
            told = run("deepslam", "library", "build", "-o", self.folder / "library", code=2, env=self.environment, cwd=self.folder)
        finally:
            listed.write_text(kept)
        self.assertIn(str(listed), told.stderr)

    def test_scripts_tell_what_they_take(self):
        for name in ("deepslam-demo", "deepslam-fetch-weights"):
            self.assertIn("--downloads DIR", run(name, "--help", env=self.environment).stdout)
            self.assertIn("unknown option", run(name, "--wrong", code=2, env=self.environment).stderr)

    def test_a_project_finds_the_libraries(self):
        source = self.prefix / "share/doc/deepslam/examples/consumer"
        build = self.folder / "consumer"
        environment = dict(os.environ)
        run("cmake", "-S", source, "-B", build, f"-DCMAKE_PREFIX_PATH={self.prefix}", env=environment)
        run("cmake", "--build", build, env=environment)
        capture = self.folder / "flat"
        for kind in ("rgb", "depth"):
            (capture / kind).mkdir(parents=True)
        for i in range(3):
            captures.write_png(capture / "rgb" / f"{i}.png", 64, 48, 8, 2, [bytes(64 * 3)] * 48)
            captures.write_depth(capture / "depth" / f"{i}.png", 64, 48, 1500 + 100 * i)
        for kind in ("rgb", "depth"):
            (capture / f"{kind}.txt").write_text("".join(f"{i}.0 {kind}/{i}.png\n" for i in range(3)))
        (capture / "capture.yaml").write_text("format: tum\ndepth_units_per_m: 1000\n"
                                              "camera: {width: 64, height: 48, fx: 60, fy: 60, cx: 31.5, cy: 23.5}\n")
        told = run(build / "capture_depth", capture).stdout
        self.assertEqual(told, "tum: 3 frames of 64 x 48\n" + "".join(
            f"frame {i}: 100.0 % valid, mean {1.5 + 0.1 * i:.3f} m\n" for i in range(3)))
        run(build / "capture_depth", self.folder / "nothing", code=3)

    def test_packages_refuse_what_they_have_not(self):
        source = self.folder / "asks"
        source.mkdir()
        for text, expected in (("find_package(deepslam 0.1 REQUIRED COMPONENTS wings)", "no library 'wings'"),
                               ("find_package(deepslam 9 REQUIRED)", "0.1.0")):
            (source / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.25)\nproject(asks CXX)\n{text}\n")
            told = run("cmake", "-S", source, "-B", source / "build", f"-DCMAKE_PREFIX_PATH={self.prefix}", code=1)
            self.assertIn(expected, told.stderr)

    def test_every_library_links(self):
        """All exported targets with all their dependencies, which no component asked for one by one would show."""
        source = self.folder / "all"
        source.mkdir()
        (source / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(every CXX)\nfind_package(deepslam REQUIRED)\n"
            "add_executable(every main.cc)\n"
            "target_link_libraries(every PRIVATE deepslam::stages deepslam::synth deepslam::batch)\n")
        (source / "main.cc").write_text(
            '#include "deepslam/stages/config.h"\n#include "deepslam/stages/plan.h"\n'
            "int main() { return deepslam::stages::LoadClasses(deepslam::stages::Config()).ok() ? 0 : 1; }\n")
        run("cmake", "-S", source, "-B", source / "build", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        run("cmake", "--build", source / "build")
        run(source / "build" / "every", env=self.environment)


if __name__ == "__main__":
    unittest.main()
