#!/usr/bin/env python3
"""Bad input: the message names file, line or field, value and remedy; the exit code fits; nothing is half-written.

    bad_input_test.py DEEPSLAM

A run that is refused leaves either no workspace or one that the next run uses: every test that damages something
repairs it and compares the result with that of an undisturbed run, byte by byte.
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import captures
import onnx_files

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SKIPPED = 77
SIZE = (320, 240)
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-bad-")
DIR = pathlib.Path(TEMP.name)
ROOM = captures.make_room(PROGRAM, DIR / "room")
BOXES = DIR / "boxes.json"


def run(capture, workspace, *more, **options):
    return captures.deepslam(PROGRAM, "run", capture, "-o", workspace, *captures.BARE, "--progress", "none", *more,
                             **options)


def with_boxes(capture, workspace, *more, **options):
    return run(capture, workspace, "--set", "detect.source=file", "--set", f"detect.file={BOXES}", *more, **options)


def artifacts(workspace):
    return {str(file.relative_to(workspace)): file.read_bytes() for file in workspace.rglob("*")
            if file.is_file() and file.name not in ("timing.json", "timing.html", ".lock")}


def leftovers(workspace):
    return [str(path) for path in workspace.rglob("*") if ".partial" in path.name or ".tmp-" in path.name]


def edit(name, old, new):
    def change(capture):
        text = (capture / name).read_text()
        assert old in text, text
        (capture / name).write_text(text.replace(old, new, 1))
    return change


def write(name, data):
    return lambda capture: captures.replace(capture / name, data if isinstance(data, bytes) else data.encode())


def summary(workspace, stage):
    return json.loads((workspace / stage / "manifest.json").read_text())["summary"]


class BadInput(unittest.TestCase):
    number = 0

    def setUp(self):
        BadInput.number += 1
        self.dir = DIR / f"test{BadInput.number}"
        self.dir.mkdir()
        self.workspace = self.dir / "workspace"
        self.num_captures = 0

    def tearDown(self):
        shutil.rmtree(self.dir, ignore_errors=True)

    def capture(self, *changes, frames=None):
        self.num_captures += 1
        folder = self.dir / f"capture{self.num_captures}"
        captures.copy_capture(ROOM, folder, frames)
        for change in changes:
            change(folder)
        return folder

    def check(self, result, code, *patterns):
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        for pattern in patterns:
            self.assertRegex(result.stderr, pattern)

    def refused(self, capture, *patterns, code=3):
        """Refused before anything is written."""
        self.check(run(capture, self.workspace, "--until", "track"), code, *patterns)
        self.assertFalse(self.workspace.exists(), "nothing may be written")

    def tracked(self, capture, *patterns, more=()):
        result = run(capture, self.workspace, "--until", "track", *more)
        self.check(result, 0, *patterns)
        line = summary(self.workspace, "track")
        shutil.rmtree(self.workspace)
        return line

    def verdict(self):
        result = captures.deepslam(PROGRAM, "validate", self.workspace / "export" / "scene.glb")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = json.loads((self.workspace / "export" / "map.json").read_text())
        return document["verdict"], "; ".join(document["reasons"]), document["objects"]


class Captures(BadInput):
    def test_missing_folder_or_file(self):
        file = self.dir / "file"
        file.write_text("x")
        self.refused(self.dir / "nowhere", "nowhere: folder is missing; name a capture's folder")
        self.refused(file, "file: not a folder; name the folder")
        self.refused(self.capture(*[(lambda name: lambda c: (c / name).unlink())(name)
                                    for name in ("associations.txt", "depth.txt")]),
                     r"depth\.txt: file is missing; a capture needs")

    def test_lists_that_are_empty_or_malformed(self):
        for change, pattern in [
                (write("associations.txt", ""), r"associations\.txt: lists no images; a line reads"),
                (write("associations.txt", "# nothing\n"), "lists no images"),
                (edit("associations.txt", " depth/000003.png", ""), r"associations\.txt:4: has 3 fields, expected 4"),
                (edit("associations.txt", "0.200000", "0.2x"), r"associations\.txt:4: field 'time' is '0.2x'.*correct"),
                (edit("associations.txt", "0.200000", "nan"), r":4: field 'time' is 'nan'"),
                (edit("associations.txt", "rgb/000003", "/etc/rgb/000003"), ":4: field 'file' is '/etc.*absolute"),
                (edit("associations.txt", "rgb/000003", "../rgb/000003"), ":4: field 'file'.*leaves the capture"),
                (write("associations.txt", bytes(range(256)) * 9), r"associations\.txt:\d+: "),
                (edit("groundtruth.txt", "0.200000 ", "0.200000 x"), r"groundtruth\.txt:\d+: field 'tx' is 'x")]:
            with self.subTest(pattern):
                self.refused(self.capture(change), pattern)

    def test_unsorted_and_duplicated_lists_are_put_in_order(self):
        lines = (ROOM / "associations.txt").read_text().splitlines()
        lines = [line for line in lines if not line.startswith("#")]
        line = self.tracked(self.capture(write("associations.txt", "\n".join(lines[::-1] + lines[:3]))),
                            "times are not ascending; lines were sorted", "3 lines repeat a time and were left out")
        self.assertIn("10 frames, 0 lost", line)

    def test_a_clock_that_was_set_back_changes_no_pose(self):
        def set_back(name, columns):
            def change(capture):
                lines = [line.split() for line in (capture / name).read_text().splitlines() if not line.startswith("#")]
                for line in lines:
                    for column in columns:
                        line[column] = f"{float(line[column]) - (0.23 if float(line[column]) > 0.3 else 0):.6f}"
                captures.replace(capture / name, "\n".join(map(" ".join, lines)).encode())
            return change
        changed = self.capture(set_back("associations.txt", (0, 2)), set_back("groundtruth.txt", (0,)))
        for poses in ("track", "capture"):
            trajectories = []
            for capture, patterns in [(self.capture(), []), (changed, [r"associations\.txt:\d: the time falls back"])]:
                result = run(capture, self.workspace, "--until", "track", "--poses", poses)
                self.check(result, 0, *patterns)
                self.assertIn("10 frames, 0 lost", summary(self.workspace, "track"))
                lines = (self.workspace / "track" / "trajectory.tum").read_text().splitlines()[1:]
                trajectories.append([list(map(float, line.split())) for line in lines])
                shutil.rmtree(self.workspace)
            straight, jumped = trajectories
            self.assertLess(jumped[5][0], jumped[4][0])
            for a, b in zip(straight, jumped, strict=True):
                for x, y in zip(a[1:], b[1:], strict=True):
                    self.assertAlmostEqual(x, y, delta=1e-4)  # times are rounded, and predictions with them

    def test_bad_images_are_skipped_and_counted(self):
        jpeg = (ROOM / "rgb" / "000001.jpg").read_bytes()
        png = (ROOM / "depth" / "000002.png").read_bytes()
        huge = png[:16] + b"\x7f\xff\xff\xff" * 2 + png[24:]
        for name, change, pattern in [
                ("missing", lambda c: (c / "rgb/000003.jpg").unlink(), "000003.jpg: file is missing"),
                ("a folder", lambda c: [(c / "rgb/000003.jpg").unlink(), (c / "rgb/000003.jpg").mkdir()], "not a file"),
                ("truncated colour", write("rgb/000003.jpg", jpeg[:len(jpeg) // 2]), "ends too early"),
                ("truncated depth", write("depth/000003.png", png[:len(png) // 2]), "ends too early"),
                ("damaged depth", write("depth/000003.png", png[:900] + bytes([png[900] ^ 255]) + png[901:]), "readable"),
                ("huge depth", write("depth/000003.png", huge), "too few for 2147483647 x 2147483647"),
                ("empty", write("rgb/000003.jpg", b""), "file is empty"),
                ("text", write("depth/000003.png", b"hello"), "is no depth image that is read here"),
                ("size", lambda c: captures.write_depth(c / "depth/000003.png", 160, 120, 900), "160 x 120 px"),
                ("8 bit depth", lambda c: captures.write_png(c / "depth/000003.png", *SIZE, 8, 0, [b"\7" * 320] * 240),
                 "depth must have one channel of 16 bits, this has 1 of 8 bits"),
                ("depth as colour", write("rgb/000003.jpg", png), "16 bits per channel")]:
            with self.subTest(name):
                line = self.tracked(self.capture(change), "frame 3 skipped: .*" + pattern)
                self.assertIn("10 frames, 0 lost, 1 unreadable", line)

    def test_captures_of_mostly_bad_images_are_refused(self):
        bad = [write(f"depth/{i:06d}.png", b"hello") for i in range(1, 8)]
        for poses in ("track", "capture"):
            result = run(self.capture(*bad), self.workspace, "--until", "track", "--poses", poses)
            self.check(result, 3, r"7 of 10 frames could not be read; the first: .*000001\.png: is no depth image that is read here")
            self.assertEqual(leftovers(self.workspace), [])
        gone = [(lambda i: lambda c: (c / f"depth/{i:06d}.png").unlink())(i) for i in range(7)]
        shutil.rmtree(self.workspace)
        self.refused(self.capture(*gone), "7 of 10 frames lack an image: is the capture unpacked completely")

    def test_single_bad_frames_do_not_stop_given_poses(self):
        line = self.tracked(self.capture(write("depth/000003.png", b"hello")), "frame 3 skipped",
                            more=("--poses", "capture"))
        self.assertIn("1 unreadable", line)
        result = run(self.capture(lambda c: (c / "groundtruth.txt").unlink()), self.workspace, "--poses", "capture")
        self.check(result, 3, "groundtruth.txt is missing.*use --poses track")

    def test_no_depth(self):
        def without(*which):
            return [(lambda i: lambda c: captures.write_depth(c / f"depth/{i:06d}.png", *SIZE, 0))(i) for i in which]
        self.refused(self.capture(*without(*range(10))), "no valid depth.*check the depth images and 'depth_units_per_m'")
        self.assertIn("10 frames, 3 lost", self.tracked(self.capture(*without(3, 4, 5))))
        self.assertIn("10 frames, 1 lost", self.tracked(self.capture(*without(0))))
        self.check(with_boxes(self.capture(*without(*range(1, 10))), self.workspace), 0)
        verdict, reasons, _ = self.verdict()
        self.assertEqual(verdict, "bad")
        self.assertIn("could not be tracked", reasons)

    def test_intrinsics(self):
        name = "capture.yaml"
        for change, pattern in [
                (lambda c: (c / name).unlink(), r"capture\.yaml: missing, so the camera's intrinsics are unknown; write"),
                (write(name, ""), "field 'camera' is missing; a complete file reads"),
                (write(name, "camera: {width: 3\n  x: ["), r"capture\.yaml:2: not valid YAML"),
                (edit(name, "fx: 262.5", "fx: 0"), r"capture\.yaml:2: field 'camera.fx' is 0; expected .*: write"),
                (edit(name, "fx: 262.5", "fx: -262.5"), "'camera.fx' is -262.5; expected"),
                (edit(name, "fx: 262.5", "fx: .nan"), "'camera.fx' is '.nan', not a finite number"),
                (edit(name, "fx: 262.5", "fx: 1e300"), r"'camera.fx' is 1e\+300; expected"),
                (edit(name, "fx: 262.5", "fx: wide"), "'camera.fx' is 'wide', not a number"),
                (edit(name, ", fx: 262.5", ""), "'camera.fx' is missing"),
                (edit(name, "width: 320", "width: 0"), r"'camera.width' is 0; expected 1 \.\. "),
                (edit(name, "width: 320", "width: 1000000000"), "'camera.width' is 1000000000; expected"),
                (edit(name, "width: 320", "width: 1e9"), "'camera.width' is '1e9', not a whole number"),
                (edit(name, "width: 320", "width: 640"), "is 320 x 240 px, colour 640 x 240"),
                (edit(name, "cx: 159.5", "cx: 1e6"), "'camera.cx' is 1000000; expected a place inside the image"),
                (edit(name, "cy: 119.5", "cy: .inf"), "'camera.cy' is '.inf'"),
                (edit(name, "per_m: 1000", "per_m: 0"), r"capture\.yaml:3: field 'depth_units_per_m' is 0, outside"),
                (edit(name, "per_m: 1000", "per_m: 1"), "no valid depth"),
                (edit(name, "format: tum", "format: reel"), "'format' is 'reel', which is not known here")]:
            with self.subTest(pattern):
                self.refused(self.capture(change), pattern)

    def test_one_and_two_frames(self):
        for frames in (1, 2):
            self.check(with_boxes(self.capture(frames=frames), self.workspace), 0, "belongs to no frame of the capture")
            _, _, objects = self.verdict()
            self.assertLessEqual(len(objects), 3)
            shutil.rmtree(self.workspace)

    def test_nothing_detected(self):
        self.check(run(ROOM, self.workspace, "--set", "detect.clusters.enabled=false", "--set", "associate.method=votes"), 0)
        verdict, reasons, objects = self.verdict()
        self.assertEqual((verdict, objects), ("bad", []))
        self.assertIn("no object was mapped", reasons)

    def test_two_captures_in_one_are_told_where_they_meet(self):
        # A smaller room with another floor, from another height: nothing in common with the first frames.
        elsewhere = captures.SCENE
        for old, new in (("[6.2, 6.0, 2.6], floor: wood", "[3.6, 3.4, 2.4], floor: tiles"), ("radius_m: 2.5", "radius_m: 1.4"),
                         ("height_m: 1.6,", "height_m: 1.0,"), ("start_deg: -160", "start_deg: 40"), ("seed: 7", "seed: 8"),
                         ("target_height_m: 0.45", "target_height_m: 1.0")):
            assert old in elsewhere
            elsewhere = elsewhere.replace(old, new)
        second = captures.render(PROGRAM, elsewhere, self.dir / "elsewhere")
        both = captures.concatenate(ROOM, second, self.dir / "both")
        self.check(with_boxes(both, self.workspace), 0)
        verdict, reasons, _ = self.verdict()
        self.assertEqual(verdict, "bad")
        self.assertRegex(reasons, r"at frame 10 the camera sees nothing in common with the frames before: where frames "
                                  r"\d+ to \d+ lie relative to the others was not measured")
        ground = json.loads((self.workspace / "ground" / "ground.json").read_text())
        self.assertEqual(ground["apart"][0]["first"], 10, "the second part's floor is looked for by itself")
        self.assertRegex(summary(self.workspace, "ground"), "did not measure against the first")
        self.assertIn("sees nothing in common", (self.workspace / "report" / "index.html").read_text())
        shutil.rmtree(self.workspace)
        self.check(with_boxes(ROOM, self.workspace), 0)
        verdict, reasons, _ = self.verdict()
        self.assertNotEqual(verdict, "bad")
        self.assertNotIn("nothing in common", reasons)

    def test_no_ground_in_view(self):
        wall = [(lambda i: lambda c: captures.write_depth(c / f"depth/{i:06d}.png", *SIZE, 2000))(i) for i in range(10)]
        self.check(with_boxes(self.capture(*wall), self.workspace), 0)
        verdict, reasons, _ = self.verdict()
        self.assertEqual(verdict, "bad")
        self.assertIn("no ground plane was found", reasons)


class Inputs(BadInput):
    def test_missing_weights_and_library(self):
        arguments = ("run", ROOM, "-o", self.workspace, "--progress", "none")
        self.check(captures.deepslam(PROGRAM, *arguments), 3, r"yolo11n-seg\.onnx; run scripts/setup.sh.*deepslam doctor")
        self.check(captures.deepslam(PROGRAM, *arguments, *captures.BARE[:2]), 3,
                   "no furniture library in .*; make it by `deepslam library build`.*deepslam doctor")
        self.assertFalse((self.workspace / "track").exists(), "told before any work")
        doctor = captures.deepslam(PROGRAM, "doctor", ROOM)
        self.check(doctor, 3, "MISSING detector weights.*run scripts/setup.sh", "MISSING furniture library.*library build")

    def test_networks_that_are_none(self):
        self.check(run(ROOM, self.workspace, "--until", "ground"), 0)
        for name, data, pattern in [
                ("random", os.urandom(4096), "not a network that can be run"),
                ("empty", b"", "file is empty"),
                ("truncated", foreign_network([1, 3, 64, 64])[:-20], "not a network that can be run"),
                ("foreign", foreign_network([1, 3, 64, 64]), "head is not known: outputs 1x3x64x64.*known are YOLOv8"),
                ("vector", foreign_network([1, 5]), "input is 1x5; expected 1x3xHxW")]:
            with self.subTest(name):
                file = self.dir / f"{name}.onnx"
                file.write_bytes(data)
                result = run(ROOM, self.workspace, "--until", "detect", "--set", "detect.source=network", "--set",
                             f"detect.weights={file}")
                self.check(result, 3, f"{name}.onnx: .*{pattern}")
                self.assertEqual(leftovers(self.workspace), [])
                self.assertFalse((self.workspace / "detect").exists())

    def test_damaged_library(self):
        data = self.dir / "data"
        (data / "library").mkdir(parents=True)
        index = data / "library" / "library.json"
        for text, pattern in [("", r"library\.json: is no index.*make it again with 'deepslam library build'"),
                              ("{\"models\": 3}", r"library\.json: .*deepslam library build")]:
            index.write_text(text)
            result = captures.deepslam(PROGRAM, "run", ROOM, "-o", self.workspace, *captures.BARE[:2], "--progress",
                                       "none", data=data)
            self.check(result, 3, pattern)

    def test_detections_of_the_user(self):
        file = self.dir / "coco.json"
        def detect():
            return run(ROOM, self.workspace, "--until", "detect", "--set", "detect.source=file", "--set",
                       f"detect.file={file}")
        self.check(detect(), 3, r"coco\.json: cannot open")
        good = {"image_id": 3, "bbox": [10, 10, 50, 50], "category_name": "chair", "score": 0.7}
        # Bytes at random may begin with an end of line, and then the fault is in line 2.
        for data, pattern in [(b"\xb7" + os.urandom(63), "not valid JSON.*line 1, column"), (b"", "not valid JSON"),
                              (b"null", "neither a COCO results list"), (b"[" * 100000, "nested deeper than 64"),
                              (b"[1, 2]", "no entry fits.*is no object .so 2 of 2"),
                              (json.dumps([{**good, "category_name": "dragon"}] * 12).encode(),
                               "no entry fits.*\"dragon\".*12 of 12.*classes.yaml"),
                              (json.dumps([{**good, "score": 9}]).encode(), "no entry fits.*score must lie in")]:
            with self.subTest(data[:9]):
                file.write_bytes(data)
                self.check(detect(), 3, r"coco\.json: .*" + pattern)
        file.write_text("[]")
        self.check(detect(), 0)
        garbage = [{"image_id": 0, "bbox": [0, 0, "x", 3], "category_name": "chair"}, {**good, "image_id": 99},
                   {**good, "category_name": "dragon"}, {**good, "bbox": [1e300, 10, 50, 50]}, {**good, "score": 7},
                   {**good, "bbox": [10, 10, -50, 50]}, {**good, "segmentation": {"size": [3, 3], "counts": "zz"}}]
        file.write_text(json.dumps(garbage + [good]))
        result = detect()
        self.check(result, 0, r"\[1\] belongs to no frame", r"\[2\] has class \"dragon\"", r"\[3\] has no usable bbox",
                   r"\[4\] has a score outside", r"\[6\].segmentation is not of the image's size")
        found = json.loads((self.workspace / "detect" / "detections.json").read_text())
        self.assertIn([10, 10, 50, 50], [row["bbox"] for row in found["annotations"]])

    def test_detections_that_hardly_fit_make_the_map_doubtful(self):
        file = self.dir / "coco.json"
        for bad_of_four, doubted in ((1, False), (3, True)):
            with self.subTest(bad_of_four):
                rows = [{**row, "score": 9 if n % 4 < bad_of_four else 0.9}
                        for n, row in enumerate(json.loads(BOXES.read_text()))]
                file.write_text(json.dumps(rows))
                num_bad = sum(row["score"] == 9 for row in rows)
                told = f"{num_bad} of {len(rows)} entries are left out"
                self.check(run(ROOM, self.workspace, "--set", "detect.source=file", "--set", f"detect.file={file}"), 0,
                           rf"coco\.json: {told}")
                verdict, reasons, _ = self.verdict()
                self.assertEqual(told in reasons, doubted, reasons)
                if doubted:
                    self.assertNotEqual(verdict, "good")
                    self.assertIn(told, (self.workspace / "report" / "index.html").read_text())

    def test_configuration(self):
        for setting, pattern in [
                ("track.keyframe_distnace_m=1", "unknown option.*did you mean track.keyframe_distance_m"),
                ("track.keyframe_distance_m=abc", "is \"abc\", must be a number"),
                ("track.keyframe_distance_m=nan", "must be a number"),
                ("track.keyframe_distance_m=-1", r"must lie in \[0.005, 10\] m"),
                ("track.keyframe_distance_m", "must be NAME=VALUE"), ("=3", "must be NAME=VALUE"),
                ("detect.source=telepathy", "must be one of network, file, none"),
                ("track.rotation_search=maybe", "must be true or false"),
                ("track.num_relocalisation_keyframes=2.5", "must be an integer")]:
            with self.subTest(setting):
                self.check(run(ROOM, self.workspace, "--set", setting), 2, "--set " + re.escape(setting) + ": ", pattern)
        file = self.dir / "mine.yaml"
        for text, pattern in [("track:\n  keyframe_distnace_m: 1\n", r"mine\.yaml:2: unknown option.*did you mean"),
                              ("x: [\n", r"mine\.yaml:2: "), ("- a\n", r"mine\.yaml:1: must be a map"),
                              ("track:\n  keyframe_distance_m: [1]\n", r"mine\.yaml:2: .*must be a single value"),
                              ("track:\n  rotation_search: 1\n  rotation_search: 2\n", r"mine\.yaml:3: .*stands twice")]:
            with self.subTest(text):
                file.write_text(text)
                self.check(run(ROOM, self.workspace, "--config", file), 2, pattern)
        self.check(run(ROOM, self.workspace, "--config", self.dir / "none.yaml"), 2, r"none\.yaml: cannot open")
        self.check(run(ROOM, ""), 2, "--output: names no folder")
        self.assertFalse(self.workspace.exists())


class Workspaces(BadInput):
    @classmethod
    def setUpClass(cls):
        result = with_boxes(ROOM, DIR / "finished")
        assert result.returncode == 0, result.stderr
        cls.finished = artifacts(DIR / "finished")

    def copy_finished(self):
        shutil.copytree(DIR / "finished", self.workspace)

    def check_finished(self, *more):
        result = with_boxes(ROOM, self.workspace, *more)
        self.check(result, 0)
        self.assertEqual(leftovers(self.workspace), [])
        now = artifacts(self.workspace)
        self.assertEqual(sorted(now), sorted(self.finished))
        self.assertEqual([name for name in now if now[name] != self.finished[name]], [])
        return json.loads(result.stdout)["ran"]

    def test_damaged_artifacts_are_made_again(self):
        self.copy_finished()
        stages = sorted(path.name for path in self.workspace.iterdir() if path.is_dir())
        self.assertEqual(len(stages), 15)
        for stage in stages:
            file = max((self.workspace / stage).rglob("*"), key=lambda f: f.stat().st_size if f.is_file() else -1)
            data = bytearray(file.read_bytes())
            data[len(data) // 2] ^= 1
            file.write_bytes(data)
            with self.subTest(file=file.name):
                self.assertEqual(self.check_finished(), [stage])

    def test_damaged_manifests_and_missing_stages_are_made_again(self):
        self.copy_finished()
        (self.workspace / "ground" / "manifest.json").write_bytes(b"")
        manifest = self.workspace / "detect" / "manifest.json"
        manifest.write_text(re.sub(r'"version": \d+', '"version": 99', manifest.read_text()))
        shutil.rmtree(self.workspace / "select")
        (self.workspace / "select").write_text("no folder")
        shutil.rmtree(self.workspace / "mesh")
        result = with_boxes(ROOM, self.workspace, "--until", "ground", "--explain")
        self.check(result, 0, "ground +runs: manifest unusable: ground/manifest.json: not valid JSON")
        self.assertEqual(self.check_finished(), ["detect", "select", "mesh"])

    def test_foreign_and_future_workspaces_are_left_alone(self):
        self.workspace.mkdir()
        (self.workspace / "cat.jpg").write_text("miau")
        self.check(run(ROOM, self.workspace), 3, "holds files but is no workspace of deepslam; choose an empty or new")
        self.assertEqual([path.name for path in self.workspace.iterdir()], ["cat.jpg"])
        self.check(run(ROOM, ROOM), 3, "holds files but is no workspace")
        self.check(run(ROOM, self.workspace / "cat.jpg"), 3, "is not a folder; name an empty or new one")
        shutil.rmtree(self.workspace)
        self.copy_finished()
        for text, pattern in [('{"format": "deepslam/workspace", "version": 99}', "use a newer deepslam; or choose another"),
                              ("", "not valid JSON.*choose another workspace")]:
            (self.workspace / "workspace.json").write_text(text)
            before = artifacts(self.workspace)
            self.check(run(ROOM, self.workspace), 3, r"workspace\.json: .*" + pattern)
            self.assertEqual(artifacts(self.workspace), before)

    def test_status_reads_a_workspace_whose_record_is_damaged(self):
        self.copy_finished()
        (self.workspace / "run.json").write_bytes(b"")
        self.check(captures.deepslam(PROGRAM, "status", self.workspace), 0, r"run\.json: not valid JSON.*writes it anew")
        self.assertEqual(self.check_finished(), [])

    def test_limit_on_file_sizes_fails_the_write(self):
        for blocks in (1, 20, 120):
            command = ["bash", "-c", f'ulimit -f {blocks}; exec "$@"', "bash", PROGRAM, "run", ROOM, "-o", self.workspace,
                       *captures.BARE, "--set", "detect.source=file", "--set", f"detect.file={BOXES}"]
            result = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=600)
            self.check(result, 1, r"cannot write: File too large; raise the limit on file sizes")
            self.assertEqual(leftovers(self.workspace), [])
        self.check_finished()

    def test_full_and_read_only_disks(self):
        disk = self.dir / "disk"
        disk.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(disk)]
        if subprocess.run(mount, capture_output=True).returncode != 0:
            self.skipTest("may not mount a small disk here; test_limit_on_file_sizes looks at the same path")
        try:
            self.workspace = disk / "workspace"
            self.check(with_boxes(ROOM, self.workspace), 1, "No space left on device; free some space and run again")
            self.assertEqual(leftovers(self.workspace), [])
            subprocess.run(["mount", "-o", "remount,size=50m", str(disk)], check=True)
            self.check_finished()
            subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
            self.check(run(ROOM, self.workspace), 1, "Read-only file system; choose a workspace you may write to")
            self.check(run(ROOM, disk / "new"), 1, "Read-only file system; choose a folder on a writable")
            self.check(captures.deepslam(PROGRAM, "status", self.workspace), 0, "report +done")
        finally:
            subprocess.run(["umount", str(disk)], check=True)

    def test_two_runs_at_once(self):
        command = [PROGRAM, "run", ROOM, "-o", self.workspace, *captures.BARE, "--set", "detect.source=file", "--set",
                   f"detect.file={BOXES}"]
        first = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            while not (self.workspace / "run.json").exists() and first.poll() is None:
                time.sleep(0.002)
            first.send_signal(signal.SIGSTOP)
            self.check(with_boxes(ROOM, self.workspace), 1, f"another run .process {first.pid}. works in this workspace; wait")
        finally:
            first.send_signal(signal.SIGCONT)
        self.assertEqual(first.wait(timeout=600), 0)
        self.check_finished()


def foreign_network(shape):
    """A valid ONNX network that hands its input through."""
    return onnx_files.network({"x": shape}, {"y": shape}, [onnx_files.node("Identity", ["x"], "y")])


if __name__ == "__main__":
    if ROOM is None:
        print("skipped: the furniture catalogues (Debian package sweethome3d-furniture) are not installed")
        sys.exit(SKIPPED)
    BOXES.write_text(json.dumps(captures.true_boxes(ROOM)))
    unittest.main(argv=sys.argv[:1])
