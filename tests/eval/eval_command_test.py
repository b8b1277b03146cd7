#!/usr/bin/env python3
"""`deepslam eval objects|map|selection|trajectory` as a user meets them, mostly with input that cannot be scored.

    eval_command_test.py DEEPSLAM REPOSITORY
"""
import json
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

DEEPSLAM = sys.argv[1]
REPOSITORY = pathlib.Path(sys.argv[2])


def version_of(source):
    """Version of the files that a codec of this source tree writes."""
    text = (REPOSITORY / "src/deepslam/artifact" / source).read_text()
    return int(re.search(r"JsonFormat kFormat\{[^}]*, (\d+)\}", text).group(1))


def objects_version():
    return version_of("objects_json.cc")


def detections_version():
    return version_of("detections_json.cc")


def png(width, height, value):
    """A 16-bit grey image of one value."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = (b"\0" + struct.pack(">H", value) * width) * height
    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def ply(vertices, faces):
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    data = b"".join(struct.pack("<3f", *v) for v in vertices)
    return header.encode() + data + b"".join(struct.pack("<B3i", 3, *f) for f in faces)


TETRAHEDRON = ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])


class Eval(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        root = pathlib.Path(self.folder.name)
        self.workspace = root / "workspace"
        self.capture = root / "capture"
        for folder in (self.workspace / "optimize", self.capture / "truth/meshes", self.capture / "truth/instances"):
            folder.mkdir(parents=True)
        self.write_poses(self.workspace / "optimize/trajectory.tum", range(5))
        self.write_poses(self.capture / "groundtruth.txt", range(5))
        (self.workspace / "optimize/objects.json").write_text(
            json.dumps({"format": "deepslam/objects", "version": objects_version(), "objects": [], "dropped": []}))
        (self.capture / "capture.yaml").write_text(
            "format: tum\ncamera: {width: 8, height: 6, fx: 8, fy: 8, cx: 3.5, cy: 2.5}\ndepth_units_per_m: 1000\n")
        (self.capture / "truth/objects.json").write_text(json.dumps(
            {"objects": [{"class": "chair", "mesh": "meshes/0.ply", "size_m": [1, 1, 1], "translation_m": [0, 0, 0.5],
                          "rotation_xyzw": [0, 0, 0, 1]}]}))
        (self.capture / "truth/meshes/0.ply").write_bytes(ply(*TETRAHEDRON))
        (self.capture / "truth/instances/000000.png").write_bytes(png(8, 6, 1))

    @staticmethod
    def write_poses(file, times):
        file.write_text("".join(f"{t} {t * t % 3} {t % 2} 1 0 0 0 1\n" for t in times))

    def eval(self, kind="objects", *more):
        done = subprocess.run([DEEPSLAM, "eval", kind, str(self.workspace), str(self.capture), *more], capture_output=True,
                              text=True, check=False)
        return done.returncode, done.stdout, done.stderr

    def assert_refused(self, *words):
        code, _, stderr = self.eval()
        self.assertEqual(code, 3, stderr)
        for word in words:
            self.assertIn(word, stderr)

    def test_an_empty_map_misses_everything(self):
        code, stdout, stderr = self.eval()
        self.assertEqual(code, 0, stderr)
        result = json.loads(stdout)
        self.assertEqual(result["summary"]["num_true"], 1)
        self.assertEqual(result["classes"][0]["recall"], 0)
        self.assertIn("pix3d", result["protocols"]["iou"])

    def test_the_truth_of_another_capture_is_told(self):
        self.assertNotIn("another capture", self.eval()[2])
        (self.capture / "groundtruth.txt").write_text("".join(f"{t} 0 {-5 * t} {t % 3} 0 0 0 1\n" for t in range(5)))
        code, _, stderr = self.eval()
        self.assertEqual(code, 0, stderr)
        self.assertIn("this is the truth of another capture", stderr)

    def test_an_object_no_frame_sees_is_not_asked_for(self):
        (self.capture / "truth/instances/000000.png").write_bytes(png(8, 6, 0))
        code, stdout, stderr = self.eval()
        self.assertEqual(code, 0, stderr)
        self.assertEqual(json.loads(stdout)["summary"]["num_true"], 0)
        self.assertEqual(json.loads(stdout)["summary"]["num_unseen"], 1)

    def test_boxes_of_an_annotation_are_truth(self):
        (self.capture / "truth/objects.json").unlink()
        (self.capture / "objects.json").write_text(json.dumps({"objects": [
            {"class": "cabinet", "center_m": [0, 0, 0.3], "yaw_rad": 0.1, "half_extent_m": [0.4, 0.2, 0.3]}]}))
        code, stdout, stderr = self.eval()
        self.assertEqual(code, 0, stderr)
        result = json.loads(stdout)
        self.assertEqual(result["classes"][0]["class"], "cabinet")
        for score in result["boxes"]["scores"]:
            self.assertEqual((score["num_true"], score["recall"], score["precision"]), (1, 0, 1))
        self.assertNotIn("surfaces", result["pairs"][0])

    def test_an_annotation_file_stands_in_for_the_truth(self):
        file = self.workspace / "mine.json"
        box = {"class": "sofa", "center_m": [0, 0, 0.3], "yaw_rad": 0.1, "half_extent_m": [0.4, 0.9, 0.3]}
        file.write_text(json.dumps({"objects": [box]}))
        code, stdout, stderr = self.eval("objects", "--annotation", str(file))
        self.assertEqual(code, 0, stderr)
        self.assertEqual([row["class"] for row in json.loads(stdout)["classes"]], ["sofa"])
        for change, word in (({"half_extent_m": [0.4, -0.9, 0.3]}, "half_extent_m"), ({"yaw_rad": "north"}, "yaw_rad"),
                             ({"class": 3}, "class"), ({"center_m": [0, 0]}, "center_m")):
            file.write_text(json.dumps({"objects": [{**box, **change}]}))
            code, _, stderr = self.eval("objects", "--annotation", str(file))
            self.assertEqual(code, 3, stderr)
            self.assertIn("mine.json", stderr)
            self.assertIn(word, stderr)

    def test_trajectories_that_cannot_be_scored(self):
        for times, word in ((range(100, 105), "only 0 of 5 poses"), (range(2), "only 2 of 5 poses")):
            self.write_poses(self.capture / "groundtruth.txt", times)
            code, _, stderr = self.eval("trajectory")
            self.assertEqual(code, 3, stderr)
            self.assertIn(word, stderr)

    def test_truth_without_matching_frames(self):
        self.write_poses(self.capture / "groundtruth.txt", range(100, 105))
        self.assert_refused("groundtruth.txt", "aligned")

    def test_fewer_than_three_matching_poses(self):
        self.write_poses(self.capture / "groundtruth.txt", range(2))
        self.assert_refused("groundtruth.txt", "aligned")

    def test_truth_is_read_as_run_reads_it(self):
        file = self.capture / "groundtruth.txt"
        clean = {kind: self.eval(kind)[:2] for kind in ("trajectory", "objects")}
        rows = [line.encode() for line in file.read_text().splitlines()]
        lost = b"2.5 nan nan nan 0 0 0 1"
        for data, warning in ((b"\xef\xbb\xbf" + b"\r\n".join(rows), None),
                              (b"\n".join([*rows[:3], lost, *rows[3:]]), "groundtruth.txt:4: 1 poses are not finite"),
                              (b"\xef\xbb\xbf# truth\r\n" + b"\r\n".join([lost, *rows]), "groundtruth.txt:2: 1 poses")):
            file.write_bytes(data)
            for kind, expected in clean.items():
                code, stdout, stderr = self.eval(kind)
                self.assertEqual((code, stdout), expected, stderr)
                if warning:
                    self.assertIn(warning, stderr)
            alone = subprocess.run([DEEPSLAM, "eval", "trajectory", str(self.workspace), str(file)], capture_output=True,
                                   text=True, check=False)
            self.assertEqual((alone.returncode, alone.stdout), clean["trajectory"], alone.stderr)
        file.write_bytes(b"\n".join([*rows, b"9 1 2 far 0 0 0 1"]) + b"\n")
        for kind in clean:
            code, _, stderr = self.eval(kind)
            self.assertEqual(code, 3, stderr)
            self.assertIn("groundtruth.txt:6", stderr)

    def test_trajectories_of_workspaces_are_as_they_were_written(self):
        file = self.workspace / "optimize/trajectory.tum"
        file.write_text(file.read_text() + "9 nan nan nan 0 0 0 1\n")
        for kind in ("trajectory", "objects"):
            code, _, stderr = self.eval(kind)
            self.assertEqual(code, 3, stderr)
            self.assertIn("trajectory.tum:6", stderr)

    def test_masks_of_another_size(self):
        (self.capture / "truth/instances/000000.png").write_bytes(png(9, 6, 1))
        self.assert_refused("000000.png")

    def test_masks_of_another_capture(self):
        (self.capture / "truth/instances/000000.png").write_bytes(png(8, 6, 7))
        self.assert_refused("000000.png", "7")

    def test_empty_mesh(self):
        (self.capture / "truth/meshes/0.ply").write_bytes(ply([], []))
        self.assert_refused("0.ply", "no faces")

    def test_missing_mesh_and_missing_truth(self):
        (self.capture / "truth/meshes/0.ply").unlink()
        self.assert_refused("0.ply")
        (self.capture / "truth/objects.json").unlink()
        self.assert_refused("--annotation")

    def test_a_mesh_elsewhere_is_refused(self):
        file = self.capture / "truth/objects.json"
        file.write_text(file.read_text().replace("meshes/0.ply", "../../secret.ply"))
        self.assert_refused("beside")

    def write_detections(self, *boxes, frame=0, width=8):
        (self.workspace / "detect").mkdir(exist_ok=True)
        (self.workspace / "detect/detections.json").write_text(json.dumps({
            "format": "deepslam/detections", "version": detections_version(),
            "images": [{"id": frame, "file_name": "a.jpg", "width": width, "height": 6}], "categories": [{"id": 1, "name": "chair"}],
            "annotations": [{"id": n, "image_id": frame, "category_id": 1, "category_name": name, "bbox": box, "area": 1,
                             "iscrowd": 0, "score": 0.9, "source": "network"} for n, (name, box) in enumerate(boxes)]}))

    def test_detections_are_held_against_the_masks(self):
        # The object fills the whole frame.
        self.write_detections(("chair", [0, 0, 8, 5]), ("chair", [0, 0, 2, 2]))
        code, stdout, stderr = self.eval("detections")
        self.assertEqual(code, 0, stderr)
        summary = json.loads(stdout)["summary"]
        self.assertEqual((summary["num_seen"], summary["num_found_by_network"], summary["num_objects_found"]), (1, 1, 1))
        self.assertEqual((summary["recall"], summary["precision"]), (1, 0.5))
        self.write_detections(("sofa", [0, 0, 8, 6]))
        summary = json.loads(self.eval("detections")[1])["summary"]
        self.assertEqual((summary["num_found"], summary["num_found_any_class"]), (0, 1))

    def test_detections_without_truth_or_of_another_capture(self):
        self.assertEqual(self.eval("detections")[0], 3)
        for frame, width, word in ((7, 8, "000007.png"), (0, 9, "000000.png")):
            self.write_detections(frame=frame, width=width)
            code, _, stderr = self.eval("detections")
            self.assertEqual(code, 3, stderr)
            self.assertIn(word, stderr)

    def test_nothing_to_select_from(self):
        for folder in ("propose", "register", "track"):
            (self.workspace / folder).mkdir()
        code, _, stderr = self.eval("selection")
        self.assertEqual(code, 3, stderr)

    def test_one_path_alone_is_wrong_usage(self):
        done = subprocess.run([DEEPSLAM, "eval", "objects", str(self.workspace)], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
