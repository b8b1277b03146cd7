#!/usr/bin/env python3
"""A map that is the truth scores 1, 0 and 100 %, whichever way round its symmetric objects were modelled.

    truth_against_itself_test.py DEEPSLAM TRUTH_WORKSPACE
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

DEEPSLAM, TRUTH_WORKSPACE = sys.argv[1:3]
SCENE = """seed: 5
frames: 6
frames_per_s: 10
camera: {width: 160, height: 120, fx: 130, fy: 130, cx: 79.5, cy: 59.5}
room: {size_m: [6, 6, 2.5], posters: 0}
lights: [{position_m: [0.5, 0.5, 2.4], power: 2}]
objects:
"""
ORBIT = "orbit: {radius_m: 2.4, height_m: 1.5, sweep_deg: 40}\n"
CHAIR = "  - {class: chair, model: chair.obj, position_m: [0.9, 0.2], yaw_deg: 33}\n"
TABLE = "  - {class: table, model: table.obj, position_m: [-0.4, 0.1], yaw_deg: -20}\n"
STOOL = "  - {class: stool, model: stool.obj, position_m: [0.2, -1.0], yaw_deg: 71}\n"


def obj(*boxes):
    """Boxes by their low and high corners; x left, y up, z front."""
    text, first = "", 1
    for low, high in boxes:
        text += "".join(f"v {(low, high)[n >> 2 & 1][0]} {(low, high)[n >> 1 & 1][1]} {(low, high)[n & 1][2]}\n"
                        for n in range(8))
        for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
            text += f"f {first + a} {first + b} {first + c} {first + d}\n"
        first += 8
    return text


def on_legs(width, depth, height, *more):
    legs = [((x, 0, z), (x + 0.06, height, z + 0.06)) for x in (-width / 2, width / 2 - 0.06)
            for z in (-depth / 2, depth / 2 - 0.06)]
    return obj(*legs, ((-width / 2, height - 0.06, -depth / 2), (width / 2, height, depth / 2)), *more)


class TruthAgainstItself(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "chair.obj").write_text(on_legs(0.5, 0.44, 0.46, ((-0.25, 0.46, -0.22), (0.25, 0.92, -0.16))))
        (self.root / "table.obj").write_text(on_legs(0.8, 1.4, 0.74))
        (self.root / "stool.obj").write_text(on_legs(0.4, 0.4, 0.5))

    def workspace(self, turns, *objects):
        (self.root / "scene.yaml").write_text(SCENE + "".join(objects) + ORBIT)
        self.capture = self.root / f"capture{turns}"
        self.truth = self.root / f"workspace{turns}"
        subprocess.run([DEEPSLAM, "synth", self.root / "scene.yaml", "-o", self.capture], check=True, capture_output=True)
        subprocess.run([TRUTH_WORKSPACE, self.capture, self.truth, str(turns)], check=True)

    def eval(self, kind, *more):
        done = subprocess.run([DEEPSLAM, "eval", kind, self.truth, self.capture, *more], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("protocol", done.stdout)
        self.assertGreater(len(done.stderr.splitlines()), 2, "a table for people")
        return json.loads(done.stdout)

    def assert_objects_are_the_truth(self, num_objects, shape):
        result = self.eval("objects")
        summary = result["summary"]
        self.assertEqual(summary["num_true"], num_objects)
        self.assertEqual(summary["num_matched"], num_objects)
        self.assertEqual([(c["precision"], c["recall"]) for c in result["classes"]], [(1, 1)] * len(result["classes"]))
        self.assertEqual(result["mistaken"], [])
        boxes = result["boxes"]
        self.assertEqual([score["min_iou"] for score in boxes["scores"]], [0.25, 0.5])
        for score in boxes["scores"]:
            for name in ("recall", "recall_right_class", "precision", "precision_right_class"):
                self.assertEqual(score[name], 1, name)
        self.assertEqual((boxes["confusions"], boxes["num_merged"], boxes["num_split"]), ([], 0, 0))
        self.assertEqual([round(match["iou"], 4) for match in boxes["matches"]], [1] * num_objects)
        if shape:
            for at in result["pairs"][0]["surfaces"]:
                # Points are drawn twice, 4 of them on each cm^2.
                self.assertGreater(at["surface"]["f_score"], 0.99 if at["threshold_m"] > 0.01 else 0.9)
        else:
            self.assertNotIn("surfaces", result["pairs"][0])
        self.assertEqual(summary["placed_percent"], 100)
        self.assertEqual(summary["iou_as_placed"], 1)
        self.assertEqual(summary["chamfer_as_placed"], 0)
        self.assertEqual(summary["in_place_iou"], 1)
        if shape:
            self.assertEqual(summary["iou"], 1)
            self.assertEqual(summary["chamfer"], 0)
        for row in result["objects"]:
            self.assertLess(row["translation_m"], 1e-6)
            self.assertLess(row["rotation_deg"], 1e-4)
            self.assertLess(row["scale_percent"], 1e-4)
        return result

    def test_all_commands(self):
        self.workspace(0, CHAIR, TABLE, STOOL)
        result = self.assert_objects_are_the_truth(3, shape=True)
        self.assertEqual([row["symmetry"] for row in sorted(result["objects"], key=lambda row: row["class"])],
                         ["none", "quarter turn", "half turn"])
        self.assertEqual(self.eval("objects"), result, "the same twice")
        surfaces = self.eval("map", "--no-cloud")
        # Points are drawn twice, so that distances are those between two samples.
        for kind in ("object_map", "tsdf"):
            self.assertEqual([surfaces[kind][name] for name in ("accuracy", "completeness", "f_score")], [1, 1, 1], kind)
            self.assertLess(surfaces[kind]["accuracy_m"], 0.005)
            self.assertLess(surfaces[kind]["completeness_m"], 0.005)
        rows = {row["row"]: row for row in self.eval("selection")["rows"]}
        for name in ("initial", "greedy", "selected", "mean of all", "oracle", "retrieval only"):
            self.assertEqual((rows[name]["num_objects"], rows[name]["iou"], rows[name]["chamfer"]), (3, 1, 0), name)
            self.assertEqual(rows[name]["iou_minus_initial"], {"mean": 0, "low": 0, "high": 0})
        trajectory = self.eval("trajectory")
        self.assertEqual(trajectory["num_scored"], trajectory["num_frames"])
        for kind in ("ate_m", "rpe_m", "rpe_deg"):
            self.assertEqual(trajectory[kind], {"rmse": 0, "mean": 0, "median": 0, "max": 0}, kind)

    def test_symmetric_objects_modelled_the_other_way_round(self):
        # The table by half a turn, the square stool by a quarter: their own canonical shapes fit as well.
        self.workspace(2, TABLE, STOOL)
        self.assert_objects_are_the_truth(2, shape=True)
        self.workspace(1, STOOL)
        self.assert_objects_are_the_truth(1, shape=True)
        rows = {row["row"]: row for row in self.eval("selection")["rows"]}
        self.assertEqual((rows["selected"]["iou"], rows["selected"]["chamfer"]), (1, 0))

    def test_a_chair_has_a_front(self):
        self.workspace(2, CHAIR)
        result = self.eval("objects")["summary"]
        self.assertLess(result["iou"], 0.9, "its canonical shape is turned round")
        self.assertEqual(result["iou_as_placed"], 1, "but it stands as the true one does")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
