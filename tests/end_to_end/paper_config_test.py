#!/usr/bin/env python3
"""configs/paper.yaml does what it says, on a rendered room of bare walls walked round once and a quarter.

    paper_config_test.py DEEPSLAM REPOSITORY
"""
import json
import pathlib
import sys
import tempfile
import unittest

import captures
import rigid

PROGRAM, REPOSITORY = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
sys.path.insert(0, str(REPOSITORY / "scripts" / "experiments"))
import loops  # noqa: E402

SKIPPED = 77
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-paper-")
DIR = pathlib.Path(TEMP.name)
SEED, FRAMES = 2, 90  # frame to frame by depth alone drifts by 4 cm there


def run(capture, workspace, *options):
    done = captures.deepslam(PROGRAM, "run", capture, "-o", workspace, "--config", REPOSITORY / "configs" / "paper.yaml",
                             "--progress", "none", *options)
    assert done.returncode == 0, done.stderr
    return workspace


def poses(workspace):
    """World from camera of every frame, as rotation and translation."""
    return [(rigid.rotation_of(pose[3:]), pose[:3]) for pose in captures.read_poses(workspace / "track" / "trajectory.tum")]


def steps(path):
    """Camera before from camera."""
    def step(before, after):
        turn = rigid.transposed(before[0])
        return rigid.product(turn, after[0]), rigid.apply(turn, rigid.subtract(after[1], before[1]))
    return [step(before, after) for before, after in zip(path, path[1:])]


def ate_m(trajectory, capture):
    done = captures.deepslam(PROGRAM, "eval", "trajectory", trajectory, capture / "groundtruth.txt")
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert figures["num_scored"] == figures["num_frames"] == FRAMES
    return figures["ate_m"]["rmse"]


class PaperConfig(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.room = DIR / "room"
        cls.whole = run(cls.room, DIR / "whole", *captures.BARE, "--until", "optimize")
        cls.track = (cls.whole / "track" / "trajectory.tum").read_bytes()

    def tracked(self, capture):
        return run(capture, DIR / f"{capture.name}_tracked", "--until", "track")

    def test_every_frame_is_tracked(self):
        frames = json.loads((self.whole / "track" / "frames.json").read_text())["frames"]
        self.assertEqual({frame["status"] for frame in frames} - {"tracked", "degenerate"}, set())

    def test_colour_changes_no_byte_of_the_tracked_path(self):
        other = captures.copy_capture(self.room, DIR / "other_colours")
        images = sorted((self.room / "rgb").iterdir())
        for image, instead in zip(images, reversed(images)):
            (other / "rgb" / image.name).unlink()
            (other / "rgb" / image.name).symlink_to(instead.resolve())
        self.assertEqual((self.tracked(other) / "track" / "trajectory.tum").read_bytes(), self.track)

    def test_frames_to_come_change_no_byte_of_the_tracked_path(self):
        """Where the path is refined, keyframes that see the same later move those before."""
        half = self.tracked(captures.copy_capture(self.room, DIR / "half", FRAMES // 2))
        mine = (half / "track" / "trajectory.tum").read_bytes()
        self.assertEqual(len(captures.read_poses(half / "track" / "trajectory.tum")), FRAMES // 2)
        self.assertTrue(self.track.startswith(mine))

    def test_a_step_is_that_of_two_frames_whatever_frame_was_first(self):
        """But for where Gauss-Newton ends that begins elsewhere: there is no motion before the first frame to predict from.

        By 0.1 to 0.2 mm, by the processor that renders the room. Aligned to keyframes, which are others then, steps
        differ by millimetres.
        """
        late = captures.copy_capture(self.room, DIR / "late", first=1)
        mine, whole = steps(poses(self.tracked(late))), steps(poses(self.whole))[1:]
        self.assertEqual(len(mine), FRAMES - 2)
        for a, b in zip(mine, whole):
            off = [rigid.subtract(a[1], b[1])] + [rigid.subtract(row, other) for row, other in zip(a[0], b[0])]
            self.assertLess(max(abs(x) for row in off for x in row), 5e-4)

    def test_keyframes_are_joined_to_the_next_alone(self):
        lines = [line.split() for line in (self.whole / "track" / "odometry.g2o").read_text().splitlines()]
        keyframes = [int(words[1]) for words in lines if words[0] == "VERTEX_SE3:QUAT"]
        edges = [(int(words[1]), int(words[2])) for words in lines if words[0] == "EDGE_SE3:QUAT"]
        self.assertGreater(len(keyframes), 20)
        self.assertEqual(sorted(edges), list(zip(keyframes, keyframes[1:])))

    def test_closing_the_path_leaves_two_centimetres_or_a_tenth_of_the_drift(self):
        drift, left = (ate_m(self.whole / stage / "trajectory.tum", self.room) for stage in ("track", "optimize"))
        print(f"drift {100 * drift:.2f} cm, left {100 * left:.2f} cm", file=sys.stderr)
        self.assertGreater(drift, 0.02, "else there is nothing to close")
        self.assertLessEqual(left, max(0.02, 0.1 * drift))


if __name__ == "__main__":
    if captures.render(PROGRAM, loops.scene(SEED, frames=FRAMES, along_walls=False), DIR / "room") is None:
        print("skipped: sweethome3d-furniture is not installed; scripts/setup.sh installs it")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
