#!/usr/bin/env python3
"""scripts/experiments/run.py against a stand-in for the program: what it asks for, and what it does not ask for again.

    experiments_test.py REPOSITORY
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(REPOSITORY / "scripts" / "experiments"))
import cases  # noqa: E402

# Notes every call in calls.txt beside itself and writes what a run leaves, without reading anything.
STAND_IN = '''#!/usr/bin/env python3
import json, pathlib, sys
here = pathlib.Path(__file__).parent
args = sys.argv[1:]
with open(here / "calls.txt", "a") as out:
    out.write(" ".join(args) + "\\n")
if (here / "fail").exists() and (here / "fail").read_text() in args:
    sys.exit(1)
after = lambda flag: pathlib.Path(args[args.index(flag) + 1])
if args[0] == "synth":
    after("-o").mkdir(parents=True)
if args[0] == "run":
    workspace = after("-o")
    for stage in ("track", "ground", "layout", "detect", "segment", "associate", "propose", "register", "select", "loops", "export"):
        (workspace / stage).mkdir(parents=True, exist_ok=True)
        (workspace / stage / "timing.json").write_text('{"wall_s": 1.0}')
    (workspace / "workspace.json").write_text("{}")
    if not (workspace / "export" / "manifest.json").exists():
        (workspace / "export" / "manifest.json").write_text("{}")
if args[0] == "eval":
    gain = {"mean": 0.1, "low": 0.05, "high": 0.2}
    surface = {"completeness": 0.5, "accuracy": 0.25, "f_score": 1 / 3}
    after("--json").write_text(json.dumps({
        "trajectory": {"ate_m": {"rmse": 0.0123}, "num_scored": 9, "num_frames": 10},
        "objects": {"summary": {"num_true": 5, "num_mapped": 6, "num_with_shape": 4, "iou": 0.4, "iou_as_placed": 0.4,
                                "chamfer": 0.06, "in_place_iou": 0.3, "num_placed": 3},
                    "classes": [{"class": "chair", "num_found": 4}], "mistaken": []},
        "selection": {"rows": [{"row": name, "num_objects": 4, "iou": 0.4, "chamfer": 0.06, "iou_minus_initial": gain,
                                "chamfer_minus_initial": gain} for name in ("initial", "selected")]},
        "map": {"object_map": surface, "tsdf": surface,
                "bytes": {"map_json": 1000, "scene_glb": 5000, "fused_cloud": 200000, "fused_cloud_per_map": 200}},
        "detections": {"summary": {"num_frames": 10, "num_seen": 8, "num_found_by_network": 4, "num_found_any_class": 6,
                                   "recall": 0.5, "precision": 0.75, "num_objects_found": 4, "num_objects": 5},
                       "classes": [{"class": "chair", "num_seen": 8, "num_found_by_network": 4, "num_found": 4,
                                    "num_found_any_class": 6, "num_detected": 5}]}}[args[1]]))
'''

PLAIN = "frames: 200\nframes_per_s: 20\n"
LADDER = PLAIN + "rungs:\n  sensor: {}   # as it is\n  noisy: {faults: {noise_scale: 2}}\n"


class Experiments(unittest.TestCase):
    def setUp(self):
        self.temp = tempfile.TemporaryDirectory(prefix="deepslam-experiments-")
        self.addCleanup(self.temp.cleanup)
        self.dir = pathlib.Path(self.temp.name)
        self.program = self.dir / "deepslam"
        self.program.write_text(STAND_IN)
        self.program.chmod(0o755)
        (self.dir / "room.yaml").write_text(PLAIN)
        (self.dir / "ladder.yaml").write_text(LADDER)

    def run_all(self, *more, code=0):
        calls = self.dir / "calls.txt"
        calls.unlink(missing_ok=True)
        result = subprocess.run(
            [sys.executable, "-B", REPOSITORY / "scripts/experiments/run.py", "--deepslam", self.program, "--work", self.dir / "work",
             "--docs", self.dir / "docs", "--scene", self.dir / "room.yaml", "--scene", self.dir / "ladder.yaml", *more],
            capture_output=True, text=True, timeout=600)
        self.assertEqual(result.returncode, code, result.stderr)
        lines = calls.read_text().splitlines() if calls.exists() else []
        return {kind: [line for line in lines if line.startswith(kind)] for kind in ("synth", "run", "eval")}

    def test_every_rung_with_and_without_depth_and_each_once(self):
        first = self.run_all()
        self.assertEqual(len(first["synth"]), 3, "the room and two rungs; the ladder as it stands is its rung `sensor`")
        self.assertEqual(len(first["run"]), 6)
        self.assertEqual(sum("propose.use_depth=false" in line for line in first["run"]), 3)
        text = (self.dir / "docs/results.md").read_text()
        for part in ("Table 1", "degradation ladder", "TSDF", "ladder_f_score.svg", "The detector"):
            self.assertIn(part, text)
        self.assertIn("| noisy | 4 / 5 / 6 | 0.400 / 0.0600 |", text)
        for svg in (self.dir / "docs").glob("*.svg"):
            self.assertIn("scripts/experiments/run.py", svg.read_text())
        again = self.run_all()
        self.assertEqual(again["synth"], [])
        self.assertTrue(all(line.startswith("eval selection") for line in again["eval"]), "pooled sets alone are scored again")
        pooled = [line for line in again["eval"] if "table1" in line]
        self.assertEqual(len(pooled), 2)
        self.assertNotIn("noisy", pooled[0], "no object twice in Table 1")

    def test_a_changed_scene_is_rendered_again(self):
        self.run_all()
        (self.dir / "room.yaml").write_text(PLAIN + "seed: 5\n")
        again = self.run_all()
        self.assertEqual(len(again["synth"]), 1)
        self.assertIn("room.yaml", again["synth"][0])

    def test_one_failing_rung_leaves_the_others_and_is_told(self):
        (self.dir / "fail").write_text("noisy")
        self.run_all(code=1)
        self.assertIn("Not run yet, or failed (see the logs): ladder_noisy", (self.dir / "docs/results.md").read_text())
        (self.dir / "fail").unlink()
        self.assertEqual(len(self.run_all()["synth"]), 1)

    def test_shortened_scenes_take_the_same_time(self):
        text = cases.with_fewer_frames(PLAIN, 60)
        self.assertIn("frames: 60\nframes_per_s: 6\n", text)
        self.assertEqual(cases.with_fewer_frames(PLAIN, 200), PLAIN)
        text = cases.with_half_images(PLAIN + "camera: {width: 640, height: 480, fx: 525.0, fy: 525.0, cx: 319.5, cy: 239.5}\n")
        self.assertIn("{width: 320, height: 240, fx: 262.5, fy: 262.5, cx: 159.5, cy: 119.5}", text)

    def test_rungs_of_the_scenes(self):
        self.assertEqual(cases.rungs_of(PLAIN), [""])
        self.assertEqual(cases.rungs_of(LADDER), ["sensor", "noisy"])
        self.assertEqual(cases.rungs_of(PLAIN + "rungs:\n  held:\n    seed: 3\nseed: 1\n"), ["", "held"])
        ladder = (REPOSITORY / "configs/scenes/ladder.yaml").read_text()
        self.assertIn("table_edges", cases.rungs_of(ladder))


if __name__ == "__main__":
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    unittest.main(argv=sys.argv[:1])
