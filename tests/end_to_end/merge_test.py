#!/usr/bin/env python3
"""A capture whose second lap has drifted away. Far: objects are found twice, re-identified as a constellation, and become one
each, whatever made their shapes. A little: objects are found once, in views that contradict each other until a loop by appearance
brings them together, and are scored anew.

    merge_test.py DEEPSLAM REPOSITORY

Exit 77: catalogues are not installed.
"""
import json
import math
import pathlib
import statistics
import sys
import tempfile
import unittest

import captures

PROGRAM = sys.argv[1]
TEMP = tempfile.TemporaryDirectory()
DIR = pathlib.Path(TEMP.name)
FAR = ((1.6, -1.8), 4.0)  # shift (m) and turn (deg) of the second lap's poses, which are given
LITTLE = ((0.16, -0.12), 1.0)
# The given poses are perfect but for the shift, and the laps follow each other at once.
OPTIONS = ("--set", "detect.source=file", "--set", "detect.frames=all", "--set", "propose.retrieval=false", "--set", "propose.network=true",
           "--set", "track.poses=capture", "--set", "loops.min_gap_frames=1", "--set", "loops.drift_base_m=3", "--progress", "none")
# The surface of a path that contradicts itself shows things twice in each other: objects by votes.
BY_OBJECTS = ("--set", "loops.appearance.enabled=false", "--set", "associate.method=votes")
BY_IMAGES = ("--set", "loops.constellations=false", "--set", "loops.appearance.min_gap_keyframes=4")


def drifted(numbers, shift_m, turn_deg):
    """A TUM pose (x y z, quaternion x y z w) turned about the vertical and shifted."""
    x, y, z, *q = numbers
    c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    w, k = math.cos(math.radians(turn_deg) / 2), math.sin(math.radians(turn_deg) / 2)
    turned = (w * q[0] - k * q[1], w * q[1] + k * q[0], w * q[2] + k * q[3], w * q[3] - k * q[2])
    return (c * x - s * y + shift_m[0], s * x + c * y + shift_m[1], z, *turned)


def two_laps(room, target, drift):
    """The room's frames twice, the second time with poses that have drifted; boxes.json beside them."""
    for kind in ("rgb", "depth"):
        (target / kind).mkdir(parents=True)
    poses = captures.read_poses(room / "groundtruth.txt")
    lists = {"rgb": [], "depth": [], "groundtruth": []}
    for lap in range(2):
        for n, pose in enumerate(poses):
            frame = lap * len(poses) + n
            for kind in ("rgb", "depth"):
                source = sorted((room / kind).iterdir())[n]
                (target / kind / f"{frame:04d}{source.suffix}").symlink_to(source.resolve())
                lists[kind].append(f"{frame / 15:.6f} {kind}/{frame:04d}{source.suffix}")
            numbers = pose if lap == 0 else drifted(pose, *drift)
            lists["groundtruth"].append(f"{frame / 15:.6f} " + " ".join(f"{number:.9f}" for number in numbers))
    for name, lines in lists.items():
        (target / f"{name}.txt").write_text("\n".join(lines) + "\n")
    (target / "capture.yaml").write_text((room / "capture.yaml").read_text())
    boxes = captures.true_boxes(room)
    again = [dict(box, image_id=box["image_id"] + len(poses)) for box in boxes]
    (target / "boxes.json").write_text(json.dumps(boxes + again))
    return target


class Laps(unittest.TestCase):
    @classmethod
    def reconstruct(cls, name, drift, options):
        cls.capture = two_laps(ROOM, DIR / name, drift)
        cls.workspace = DIR / f"{name}.workspace"
        cls.result = captures.deepslam(PROGRAM, "run", cls.capture, "-o", cls.workspace, *OPTIONS, *options,
                                       "--set", f"detect.file={cls.capture / 'boxes.json'}")

    def read(self, file):
        return json.loads((self.workspace / file).read_text())

    def assert_registrations(self, objects, scored):
        """Of all candidates of the objects scored anew, the chosen one where the object stands."""
        placed = {r["candidate"]: r for r in self.read("loops/registrations.json")["registrations"]}
        own = [o for o in objects if o["id"] in scored]
        self.assertEqual(set(placed), {score["candidate"] for o in own for score in o["scores"]})
        for o in own:
            for axis in range(3):
                self.assertAlmostEqual(placed[o["chosen"]]["world_from_object"]["translation_m"][axis],
                                       o["world_from_object"]["translation_m"][axis], 6)

    def assert_meshes(self):
        for o in self.read("export/map.json")["objects"]:
            self.assertTrue((self.workspace / f"mesh/objects/{o['name']}.ply").exists(), o["name"])


class FarDrift(Laps):
    @classmethod
    def setUpClass(cls):
        cls.reconstruct("far", FAR, BY_OBJECTS)

    def test_objects_reidentified_become_one_each(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        before = self.read("select/objects.json")["objects"]
        after = self.read("loops/objects.json")["objects"]
        self.assertGreaterEqual(len(before), 4, "two at least are seen twice")
        self.assertEqual(2 * len(after), len(before))
        self.assertTrue(all(o["merged"] for o in after))
        self.assertTrue(any(o["source"] == "completed" for o in before), "shapes of stage select take part")
        made = self.read("loops/candidates.json")["candidates"]
        self.assertEqual({c["object"] for c in made}, {o["id"] for o in after}, "completed anew by the views of both laps")
        self.assertFalse({c["id"] for c in made} & {c["id"] for c in self.read("select/candidates.json")["candidates"]})
        self.assert_registrations(after, {o["id"] for o in after})
        for o in after:
            self.assertTrue((self.workspace / "loops/models" / f"{o['model']}.binvox").exists(), o["model"])
        frames = {id: {m["frame"] for m in track["members"]}
                  for id, track in ((t["id"], t) for t in self.read("loops/tracks.json")["tracks"])}
        half = len(list((self.capture / "rgb").iterdir())) // 2
        for o in after:
            self.assertTrue(min(frames[o["id"]]) < half <= max(frames[o["id"]]), "views of both laps")

    def test_every_object_of_the_map_has_its_mesh(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        self.assert_meshes()


class LittleDrift(Laps):
    @classmethod
    def setUpClass(cls):
        cls.reconstruct("little", LITTLE, BY_IMAGES)

    def apart_m(self, objects):
        """Where the two laps have each object by their true poses: the largest distance between the laps' medians."""
        poses = captures.read_poses(ROOM / "groundtruth.txt")
        worst = 0
        for o in objects:
            laps = ([], [])
            for view in o["views"]:
                lap, n = divmod(view["frame"], len(poses))
                if view["ok"]:
                    laps[lap].append(captures.apply(poses[n], view["camera_from_object"]["translation_m"]))
            places = [[statistics.median(axis) for axis in zip(*lap)] for lap in laps]
            worst = max(worst, math.dist(*places))
        return worst

    def test_views_that_a_loop_moved_are_scored_anew(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        loops = self.read("loops/loops.json")
        self.assertTrue(any(loop["accepted"] for loop in loops["appearance"]))
        before = self.read("select/objects.json")["objects"]
        after = self.read("loops/objects.json")["objects"]
        frames = {t["id"]: [m["frame"] for m in t["members"]] for t in self.read("loops/tracks.json")["tracks"]}
        half = len(list((self.capture / "rgb").iterdir())) // 2
        both = {o["id"] for o in before if min(frames[o["id"]]) < half <= max(frames[o["id"]])}
        self.assertTrue(both, "the drift is small: both laps see one object")
        made = self.read("loops/candidates.json")["candidates"]
        self.assertEqual({c["object"] for c in made}, both)
        self.assertTrue(all(c["model"].startswith(("closed_", "closed2_")) for c in made), made)
        self.assert_registrations(after, both)
        self.assertGreater(self.apart_m([o for o in before if o["id"] in both]), 0.15)
        self.assertLess(self.apart_m([o for o in after if o["id"] in both]), 0.03)
        self.assert_meshes()


if __name__ == "__main__":
    ROOM = captures.make_room(PROGRAM, DIR / "room")
    if ROOM is None:
        print("sweethome3d-furniture is not installed")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
