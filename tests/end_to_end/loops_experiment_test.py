#!/usr/bin/env python3
"""The scoring of scripts/experiments/loops.py, on a workspace made up here whose truth is known.

    loops_experiment_test.py REPOSITORY
"""
import json
import math
import pathlib
import re
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(REPOSITORY / "scripts" / "experiments"))
import loops  # noqa: E402

LEVEL = [0, 0, 0, 1]


def at(x, y):
    return {"rotation_xyzw": LEVEL, "translation_m": [x, y, 0]}


def seen(object_id, frame, x, y):
    """An object whose best view, from frame `frame` at (frame / 10, 0), saw it at (x, y) of the world."""
    views = [{"ok": True, "inlier_share": 0.9, "frame": frame, "camera_from_object": at(x - frame / 10, y)},
             {"ok": False, "inlier_share": 1.0, "frame": frame, "camera_from_object": at(9, 9)}]
    return {"id": object_id, "views": views}


class Scoring(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.capture = pathlib.Path(self.folder.name, "capture")
        self.workspace = pathlib.Path(self.folder.name, "workspace")
        self.write(self.capture / "groundtruth.txt",
                   "# time x y z qx qy qz qw\n" + "".join(f"{k} {k / 10} 0 0 0 0 0 1\n" for k in range(100)))
        self.write(self.capture / "truth/objects.json",
                   {"objects": [{"translation_m": [0, 2, 0.4]}, {"translation_m": [3, 2, 0.4]}]})
        self.write(self.workspace / "track/frames.json", {"frames": [{"frame": k, "time_s": k} for k in range(100)]})

    @staticmethod
    def write(path, value):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(value if isinstance(value, str) else json.dumps(value))

    def score(self, before, after, appearance=(), merges=(), constellations=(), tracks=(), tracklets=()):
        self.write(self.workspace / "select/objects.json", {"objects": before})
        self.write(self.workspace / "loops/objects.json", {"objects": after})
        self.write(self.workspace / "loops/tracks.json",
                   {"tracks": [{"members": [{"frame": f} for f in frames]} for frames in tracks]})
        self.write(self.workspace / "loops/loops.json", {
            "appearance": [{"accepted": good, "old_keyframe": i, "new_keyframe": j, "old_from_new": pose}
                           for i, j, pose, good in appearance],
            "constellations": [{"accepted": good, "pairs": pairs} for good, pairs in constellations],
            "merges": [{"kept": a, "merged": b} for a, b in merges],
            "visits": [dict(zip(("visit", "object", "first", "last"), tracklet)) for tracklet in tracklets]})
        return loops.score(self.capture, self.workspace, {})

    def test_a_right_loop_a_wrong_one_and_a_refused_one(self):
        figures = self.score([], [], [(0, 60, at(6, 0), True), (0, 60, at(6.2, 0), True), (0, 60, at(9, 0), False)])
        self.assertEqual((figures["appearance"], figures["wrong_appearance"], figures["closed"]), (2, 1, True))
        self.assertAlmostEqual(figures["worst_appearance_m"], 0.2)

    def test_a_merge_of_two_objects_that_are_one_and_of_two_that_are_not(self):
        before = [seen(1, 0, 0, 2), seen(5, 90, 0.1, 2), seen(6, 90, 3, 2.1)]
        right = self.score(before, [before[0], before[2]], merges=[(1, 5)])
        self.assertEqual((right["wrong_merges"], right["duplicates_before"], right["duplicates"]), (0, 1, 0))
        wrong = self.score(before, before[:2], merges=[(1, 6)])
        self.assertEqual((wrong["wrong_merges"], wrong["duplicates"]), (1, 1))

    def test_tracklets_of_an_object_count_by_themselves(self):
        first, second, mine = seen(1, 0, 0, 2)["views"], seen(1, 90, 3, 2)["views"], seen(2, 70, 0.1, 2)["views"]
        before = [{"id": 1, "views": first + second}, {"id": 2, "views": mine}]
        tracklets = [(1, 1, 0, 10), (7, 1, 80, 99)]
        self.assertEqual(self.score(before, before)["mixed"], 1)
        after = [{"id": 1, "views": first + mine}, {"id": 7, "views": second}]
        right = self.score(before, after, merges=[(1, 2)], tracklets=tracklets)
        self.assertEqual((right["wrong_merges"], right["mixed"]), (0, 0))
        after = [{"id": 1, "views": first}, {"id": 2, "views": mine + second}]
        wrong = self.score(before, after, merges=[(2, 7)], tracklets=tracklets)
        self.assertEqual((wrong["wrong_merges"], wrong["mixed"]), (1, 1))

    def test_objects_reidentified_close_a_loop_when_there_are_two(self):
        self.assertFalse(self.score([], [], tracks=[[0, 99], [0, 10]])["closed"])
        self.assertTrue(self.score([], [], tracks=[[0, 99], [5, 95]])["closed"])
        self.assertTrue(self.score([], [], constellations=[(True, [1, 2])])["closed"])
        self.assertFalse(self.score([], [], constellations=[(True, [1])])["closed"], "a duplicate is no loop")

    def test_nothing_near_is_no_object(self):
        self.assertEqual(self.score([], [seen(1, 0, 8, 8), seen(2, 0, 8, 8)])["duplicates"], 0)

    def test_differences_of_poses(self):
        turned = loops.pose([0, 0, math.sin(0.05), math.cos(0.05)], [1, 2, 3])
        metres, degrees = loops.off(loops.pose(LEVEL, [1, 2, 0]), turned)
        self.assertAlmostEqual(metres, 3)
        self.assertAlmostEqual(degrees, math.degrees(0.1))
        unit = loops.times(turned, loops.inverse(turned))
        self.assertAlmostEqual(loops.off(unit, loops.pose(LEVEL, [0, 0, 0]))[0], 0)


class Scenes(unittest.TestCase):
    def test_two_chairs_stand_twice_in_odd_rooms_only(self):
        for seed in range(20):
            models = re.findall(r"class: chair, model: (\"[^\"]+\")", loops.scene(seed))
            self.assertEqual(len(models), 6)
            self.assertEqual(len(set(models)), 4 if seed % 2 else 6, seed)
            self.assertEqual(loops.scene(seed), loops.scene(seed))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
