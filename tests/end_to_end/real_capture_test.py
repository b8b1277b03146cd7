#!/usr/bin/env python3
"""Two real captures from the folder DEEPSLAM_TEST_DATA, through the program as a user runs it.

    real_capture_test.py DEEPSLAM REPOSITORY

redkitchen: 500 frames, chairs round one table, counters along the walls. fr3_cabinet: sparse keyframes round a cabinet with a known box.
"""
import argparse
import json
import math
import os
import pathlib
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import unittest

import rigid

sys.path.insert(0, str(pathlib.Path(sys.argv[2]).resolve() / "scripts" / "experiments"))
import halves  # noqa: E402

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SKIPPED = 77
DATA = pathlib.Path(os.environ.get("DEEPSLAM_TEST_DATA", "/nonexistent")) / "data"
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-real-")
DIR = pathlib.Path(TEMP.name)

# Sanitizers cost many times the time and memory.
SANITIZED = os.environ.get("DEEPSLAM_SANITIZED") == "1"
MAX_WALL_S = 240
MAX_MEMORY_KIB = 2 * 1024 * 1024
MAX_ATE_M = 0.03
MAX_GROUND_GAP_M = 0.04
MAX_GAP_OF_DOUBTFUL_M = 0.1  # of what the map itself is not sure of, as a corner unit of which a front was seen
SURE = 0.5
ALIKE = 0.01  # shares of pixels that differ by less are the noise of which frames go to which half
TABLE_TOP_M, TABLE_TOLERANCE_M = 0.74, 0.05
MAY_HANG = ("tv", "furniture")  # of what these captures show ...
WALL_CABINET_M = 0.5  # ... beside cabinets and shelves on a wall, which begin at least as high
SAME_PLACE_M = 0.3  # two objects of one class nearer than this are one, mapped twice
MIN_SILHOUETTE_IOU = 0.45  # of a unit in a corner, whose sides run into its neighbours, half is measured as theirs
MIN_IOU_OF_DOUBTFUL = 0.4  # of what the map itself is not sure of
MIN_BOX_IOU = 0.25


class Run:
    """A whole run with its wall time, processor time and peak memory."""

    def __init__(self, capture, workspace, *more):
        self.capture, self.workspace = DATA / capture, DIR / workspace
        begin = time.monotonic()
        command = [PROGRAM, "run", self.capture, "-o", self.workspace, "--progress", "none", *more]
        child = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        with child.stdout:
            self.output = child.stdout.read()
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        assert child.returncode == 0, self.output
        self.wall_s = time.monotonic() - begin
        self.cpu_s = usage.ru_utime + usage.ru_stime
        # Every stage starts the process's peak anew, so that the system tells of the last one alone.
        stages = [json.loads(file.read_text()) for file in self.workspace.glob("*/timing.json")]
        self.memory_kib = max(usage.ru_maxrss, *(1024 * stage["peak_memory_mib"] for stage in stages))
        self.map = json.loads((self.workspace / "export" / "map.json").read_text())
        print(f"{workspace}: {self.wall_s:.0f} s wall, {self.cpu_s:.0f} s of processors, {self.memory_kib / 1024:.0f} MiB, "
              f"verdict {self.map['verdict']}", file=sys.stderr)

    def ask(self, *arguments):
        result = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=1200)
        print(result.stderr, end="", file=sys.stderr)
        assert result.returncode == 0, result.stderr
        return json.loads(result.stdout)

    def objects(self, class_name=None):
        return [o for o in self.map["objects"] if class_name in (None, o["class"])]


def centre(thing):
    return thing["world_from_object"]["translation_m"]


def vertical_range(thing):
    """Lowest and highest point of an object's box."""
    rotation = rigid.rotation_of(thing["world_from_object"]["rotation_xyzw"])
    reach = sum(abs(rotation[2][k]) * thing["size_m"][k] / 2 for k in range(3))
    return centre(thing)[2] - reach, centre(thing)[2] + reach


def box_iou(centre_a, rotation_a, half_a, centre_b, rotation_b, half_b, samples=200000):
    """Of two oriented boxes, by points drawn in the first: volumes are known, only the overlap is drawn."""
    draw = random.Random(1)
    inside = 0
    for _ in range(samples):
        local = [draw.uniform(-h, h) for h in half_a]
        world = rigid.add(rigid.apply(rotation_a, local), centre_a)
        other = rigid.apply(rigid.transposed(rotation_b), rigid.subtract(world, centre_b))
        inside += all(abs(x) <= h for x, h in zip(other, half_b))
    volume_a, volume_b = 8 * math.prod(half_a), 8 * math.prod(half_b)
    both = volume_a * inside / samples
    return both / (volume_a + volume_b - both)


class RealCapture(unittest.TestCase):
    def check_common(self, run):
        if not SANITIZED:
            # On a machine that is busy with other things the wall clock tells of those.
            self.assertLess(min(run.wall_s, run.cpu_s), MAX_WALL_S)
            self.assertLess(run.memory_kib, MAX_MEMORY_KIB)
        for thing in run.objects():
            low, _ = vertical_range(thing)
            if thing.get("stands_on") == "floor":
                most_m = MAX_GROUND_GAP_M if thing["confidence"] >= SURE else MAX_GAP_OF_DOUBTFUL_M
                self.assertLessEqual(abs(low), most_m, f"{thing['name']} does not stand on the ground")
            else:
                hangs = thing["class"] in MAY_HANG or (thing["class"] == "cabinet" and low >= WALL_CABINET_M)
                self.assertTrue(hangs, f"{thing['name']} floats, {low:.2f} m above the ground")
            for other in run.objects(thing["class"]):
                if other is not thing:
                    self.assertGreater(math.dist(centre(thing), centre(other)), SAME_PLACE_M,
                                       f"{thing['name']} and {other['name']} are one")
        for name in ("scene.glb", "scene.uncompressed.glb"):
            report = run.ask("validate", run.workspace / "export" / name)
            self.assertEqual((report["ok"], report["warnings"]), (True, []))
            self.assertEqual(sorted(o["name"] for o in report["objects"]), sorted(o["name"] for o in run.objects()))
            self.assertTrue(all(o["closed"] for o in report["objects"]))
        silhouettes = run.ask("eval", "silhouettes", run.workspace, run.capture)
        self.assertEqual(len(silhouettes["objects"]), len(run.objects()))
        for thing in silhouettes["objects"]:
            self.assertGreater(thing["num_views"], 0, thing["name"])
        self.assertGreaterEqual(silhouettes["median_iou"], MIN_SILHOUETTE_IOU)
        sure = {thing["name"] for thing in run.objects() if thing["confidence"] >= SURE}
        for thing in silhouettes["objects"]:
            with self.subTest(silhouette=thing["name"]):
                least = MIN_SILHOUETTE_IOU if thing["name"] in sure else MIN_IOU_OF_DOUBTFUL
                self.assertGreaterEqual(thing["median_iou"], least)

    def test_redkitchen(self):
        run = Run("redkitchen", "redkitchen")
        frames = json.loads((run.workspace / "track" / "frames.json").read_text())["frames"]
        self.assertEqual([f["frame"] for f in frames if f["status"] not in ("tracked", "degenerate")], [])
        error = run.ask("eval", "trajectory", run.workspace, run.capture)
        self.assertEqual((error["num_scored"], error["num_frames"]), (500, 500))
        self.assertLessEqual(error["ate_m"]["rmse"], MAX_ATE_M)
        tables = run.objects("table")
        self.assertEqual(len(tables), 1)
        self.assertGreaterEqual(len(run.objects("chair")), 3)
        self.assertAlmostEqual(vertical_range(tables[0])[1], TABLE_TOP_M, delta=TABLE_TOLERANCE_M)
        self.check_common(run)
        self.check_networks()

    def test_keyframes_that_see_the_same_make_the_path_better(self):
        for capture in ("redkitchen", "fr3_cabinet"):
            errors = {}
            for on in ("true", "false"):
                workspace = DIR / f"path_{capture}_{on}"
                subprocess.run([PROGRAM, "run", DATA / capture, "-o", workspace, "--until", "track", "--progress", "none",
                                "--set", f"track.covisible.enabled={on}"], check=True, capture_output=True)
                errors[on] = json.loads(subprocess.run(
                    [PROGRAM, "eval", "trajectory", workspace / "track" / "trajectory.tum", DATA / capture / "groundtruth.txt"],
                    check=True, capture_output=True, text=True).stdout)["ate_m"]["rmse"]
            self.assertLess(errors["true"], errors["false"], capture)
            alone = DIR / f"path_{capture}_false" / "track" / "trajectory.tum"
            self.assertEqual((DIR / f"path_{capture}_true" / "track" / "as_tracked.tum").read_bytes(), alone.read_bytes())

    def test_what_one_half_of_the_views_selects_agrees_best_with_the_depth_of_the_other(self):
        work = DIR / "halves"
        work.mkdir()
        args = argparse.Namespace(capture=DATA / "redkitchen", deepslam=PROGRAM, work=work, run_options=[])
        workspaces = halves.mapped_halves(args)
        objects, _ = halves.scored_objects(args, workspaces)
        self.assertGreaterEqual(len(objects), 6, "three of each half")
        near, through = ({row: float(halves.mean(objects, row)[k]) for row in halves.ROWS} for k in (0, 1))
        print("of the object's depth", near, "rays through", through, file=sys.stderr)
        for row in ("initial", "fused"):
            self.assertGreater(near["selected"], near[row] - ALIKE, row)
            self.assertLess(through["selected"], through[row], row)
        shutil.copytree(workspaces["odd"], DIR / "elsewhere")
        with open(DIR / "elsewhere" / "track" / "trajectory.tum", "a", encoding="utf-8") as trajectory:
            trajectory.write("# another\n")
        other = subprocess.run([PROGRAM, "eval", "selection", "--held-out", "--judge-by", DIR / "elsewhere", workspaces["even"],
                                args.capture], capture_output=True, text=True)
        self.assertNotEqual(other.returncode, 0)
        self.assertIn("elsewhere", other.stderr)

    def check_networks(self):
        """The shape networks on top of the finished run: their candidates, refined ones, and the same by one thread."""
        options = ("--set", "select.refine.enabled=true")
        shutil.copytree(DIR / "redkitchen", DIR / "one")
        run = Run("redkitchen", "redkitchen", *options, "--threads", "2")
        self.check_common(run)
        read = lambda name: json.loads((run.workspace / name).read_text())
        made = read("select/candidates.json")["candidates"]
        proposed = {c["id"] for c in read("propose/candidates.json")["candidates"]}
        self.assertEqual({c["source"] for c in made}, {"refined", "completed"})
        self.assertFalse(proposed & {c["id"] for c in made})
        chairs = {o["id"]: o for o in read("select/objects.json")["objects"] if o["class"] == "chair"}
        self.assertEqual(set(chairs) - {c["object"] for c in made}, set(), "every chair's best network shape was refined")
        for candidate in made:
            self.assertEqual(len(candidate["latents"]), 100 if candidate["source"] == "refined" else 0)
            self.assertTrue((run.workspace / "select" / "models" / f"{candidate['model']}.binvox").is_file())
        for chair in chairs.values():
            scored = {s["candidate"] for s in chair["scores"]}
            self.assertEqual({c["id"] for c in made if c["object"] == chair["id"]} - scored, set())
        scored = json.loads(subprocess.run([PROGRAM, "eval", "selection", "--held-out", run.workspace, DATA / "redkitchen"],
                                           check=True, capture_output=True, text=True).stdout)
        by_network = []
        for row in scored["objects"]:
            by_source = [row[source] for source in ("retrieval", "network", "mean latent", "fused")]
            self.assertIn(row["as proposed"], by_source, "the best that was proposed is some source's best")
            if row["mapped"].startswith("chair"):
                by_network.append(row["network"]["agreement"])
                self.assertGreater(row["selected"]["agreement"], row["network"]["agreement"], row["mapped"])
        # Of a chair seen from behind alone a network may be wrong; of most it is right.
        self.assertGreater(statistics.median(by_network), 0.5)
        one = Run("redkitchen", "one", *options, "--threads", "1")
        for stage in ("propose", "select", "loops"):
            for file in (run.workspace / stage).rglob("*"):
                if file.is_file() and file.name != "timing.json":
                    with self.subTest(file=str(file.relative_to(run.workspace))):
                        self.assertEqual(file.read_bytes(), (one.workspace / file.relative_to(run.workspace)).read_bytes())

    def test_fr3_cabinet(self):
        run = Run("fr3_cabinet", "fr3")
        error = run.ask("eval", "trajectory", run.workspace, run.capture)
        self.assertEqual((error["num_scored"], error["num_frames"]), (58, 58))
        self.assertLessEqual(error["ate_m"]["rmse"], MAX_ATE_M)
        self.assertGreaterEqual(len(run.objects()), 1)
        self.check_common(run)

    def test_fr3_cabinet_with_its_true_poses(self):
        run = Run("fr3_cabinet", "fr3_capture", "--poses", "capture")
        self.check_common(run)
        truth = json.loads((run.capture / "objects.json").read_text())["objects"][0]
        mine = rigid.read_tum(run.workspace / "optimize" / "trajectory.tum")
        true = rigid.read_tum(run.capture / "groundtruth.txt")
        times = sorted(set(mine) & set(true))
        self.assertGreater(len(times), 50)
        # The final world is true_from_mine for every frame, up to what the graph moved.
        rotation, translation = rigid.mean_motion([(true[t], mine[t]) for t in times])
        yaw = truth["yaw_rad"]
        true_rotation = [[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]]
        overlaps = {}
        for thing in run.objects():
            if thing["class"] not in ("cabinet", "furniture"):
                continue
            own = rigid.rotation_of(thing["world_from_object"]["rotation_xyzw"])
            overlaps[thing["name"]] = box_iou(
                rigid.add(rigid.apply(rotation, centre(thing)), translation), rigid.product(rotation, own),
                [size / 2 for size in thing["size_m"]], truth["center_m"], true_rotation, truth["half_extent_m"])
        print(f"3D IoU with the true box: {overlaps}", file=sys.stderr)
        self.assertGreaterEqual(max(overlaps.values(), default=0), MIN_BOX_IOU)

    def test_threads_change_no_byte(self):
        def artifacts(run):
            return {str(f.relative_to(run.workspace)): f.read_bytes() for f in run.workspace.rglob("*")
                    if f.is_file() and f.name not in ("timing.json", "timing.html", ".lock")}
        one = artifacts(Run("fr3_cabinet", "one_thread", "--threads", "1"))
        two = artifacts(Run("fr3_cabinet", "two_threads", "--threads", "2"))
        self.assertEqual(sorted(one), sorted(two))
        self.assertEqual([name for name in one if one[name] != two[name]], [])


if __name__ == "__main__":
    if not (DATA / "redkitchen").is_dir():
        print("skipped: real captures; DEEPSLAM_TEST_DATA names no folder with data/redkitchen and data/fr3_cabinet")
        sys.exit(SKIPPED)
    doctor = subprocess.run([PROGRAM, "doctor"], capture_output=True, text=True)
    if doctor.returncode == 3:
        print("skipped: weights or furniture library are missing\n" + doctor.stderr)
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
