#!/usr/bin/env python3
"""scripts/experiments/layouts.py against a stand-in for the program, and wall_planes.py on depth of a wall whose place is known.

    layouts_experiment_test.py REPOSITORY
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(REPOSITORY / "tests" / "support"))
import python_packages  # noqa: E402

np, images = python_packages.need("numpy", "PIL.Image")
EXPERIMENTS = REPOSITORY / "scripts" / "experiments"

# Scores by seed; seed 9 fails at its run.
STAND_IN = '''#!/usr/bin/env python3
import json, pathlib, sys
command, *rest = sys.argv[1:]
if command == "synth":
    folder = pathlib.Path(rest[rest.index("-o") + 1])
    folder.mkdir(parents=True)
    (folder / "groundtruth.txt").write_text("")
elif command == "run":
    if pathlib.Path(rest[0]).name == "9":
        sys.exit(5)
elif command == "eval":
    seed = int(pathlib.Path(rest[2]).name)
    kinds = [{"kind": kind, "num_true": 3, "num_estimated": 2, "recall": 2 / 3 if kind == "door" and seed == 1 else 0}
             for kind in ("door", "window", "passage")]
    score = {"num_true_walls": 10, "missed_walls": [1] * seed, "num_walls": 8, "wrong_walls": [], "num_true_rooms": 3,
             "num_found_rooms": 3, "corner_median_m": 0.01 * seed, "room_area_error_median": 0.02, "openings": kinds}
    pathlib.Path(rest[rest.index("--json") + 1]).write_text(json.dumps({"pairs": [score]}))
'''


class Layouts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = pathlib.Path(folder.name)
        self.program = self.work / "deepslam"
        self.program.write_text(STAND_IN)
        self.program.chmod(0o755)

    def call(self, seeds):
        return subprocess.run([sys.executable, EXPERIMENTS / "layouts.py", "--deepslam", self.program, "--work", self.work / "out",
                               "--seeds", seeds], capture_output=True, text=True, timeout=60)

    def test_counts_of_homes_add_up(self):
        done = self.call("1,2")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in done.stdout.splitlines()[2:]]
        self.assertEqual([row[0] for row in rows], ["1", "2", "all"])
        self.assertEqual(rows[0][1:3], ["9 of 10", "8 of 8"])
        self.assertEqual(rows[2][1], "17 of 20")
        self.assertEqual(rows[2][6], "2 of 6, 4 told, F1 0.40")

    def test_a_home_that_fails_is_told_and_left_out(self):
        done = self.call("1,9")
        self.assertEqual(done.returncode, 1)
        self.assertIn("9: run failed with exit 5", done.stderr)
        self.assertNotIn("| 9 |", done.stdout)


class WallPlanes(unittest.TestCase):
    """A camera at the origin looks along x at a wall 2 cm behind where the map has it at x = 2, turned by 1.5 degrees."""

    def test_finds_how_far_a_wall_is_off(self):
        with tempfile.TemporaryDirectory() as name:
            capture, workspace = pathlib.Path(name, "capture"), pathlib.Path(name, "workspace")
            for folder in (capture / "depth", workspace / "export", workspace / "optimize"):
                folder.mkdir(parents=True)
            (capture / "capture.yaml").write_text(
                "camera: {width: 320, height: 240, fx: 260, fy: 260, cx: 159.5, cy: 119.5}\ndepth_units_per_m: 5000\n")
            pose = "0 0 0 1.2 -0.5 0.5 -0.5 0.5\n"  # z of the camera along x, y down
            for file in (capture / "groundtruth.txt", workspace / "optimize" / "trajectory.tum"):
                file.write_text(pose)
            (capture / "depth.txt").write_text("0 depth/0.png\n")
            u = np.arange(320)
            # Points (z, -x, ...) with normal (-cos a, sin a): z (cos a + x sin a) = 2.02 cos a, x = (u - cx) / fx.
            tilt = math.radians(1.5)
            z = 2.02 * math.cos(tilt) / (math.cos(tilt) + (u - 159.5) / 260 * math.sin(tilt))
            depth = np.tile(np.round(5000 * z), (240, 1)).astype(np.uint16)
            images.fromarray(depth).save(capture / "depth" / "0.png")
            wall = {"id": 0, "from_m": [2, -1.2], "to_m": [2, 1.2], "bottom_m": 0, "top_m": 2.5}
            (workspace / "export" / "map.json").write_text(json.dumps({"layout": {"walls": [wall]}}))
            done = subprocess.run([sys.executable, EXPERIMENTS / "wall_planes.py", workspace, capture], capture_output=True,
                                  text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line for line in done.stdout.splitlines() if line.startswith("| wall_00")]
        self.assertEqual(len(rows), 2, done.stdout)
        for row in rows:
            cells = [cell.strip() for cell in row.strip("|").split("|")]
            self.assertAlmostEqual(float(cells[5].split()[0]), -2.0, delta=0.3)
            self.assertAlmostEqual(float(cells[6].split()[0]), 1.5, delta=0.1)
            self.assertAlmostEqual(abs(float(cells[7].split()[0])), 1.5, delta=0.1)
            self.assertEqual(float(cells[4]), 1.0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
