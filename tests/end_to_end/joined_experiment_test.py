#!/usr/bin/env python3
"""scripts/experiments/joined.py on captures and a workspace made up here, whose truth is known.

    joined_experiment_test.py REPOSITORY
"""
import json
import pathlib
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(REPOSITORY / "scripts" / "experiments"))
import joined  # noqa: E402


def write_capture(folder, first_x):
    """Ten frames that go along x by 0.1 m each."""
    for kind in ("rgb", "depth"):
        (folder / kind).mkdir(parents=True)
        for k in range(10):
            (folder / kind / f"{k}.png").write_text(f"{folder.name} {kind} {k}")
        (folder / f"{kind}.txt").write_text("# time file\n" + "".join(f"{7 + k} {kind}/{k}.png\n" for k in range(10)))
    (folder / "groundtruth.txt").write_text("".join(f"{7 + k} {first_x + k / 10} 0 0 0 0 0 1\n" for k in range(10)))
    (folder / "capture.yaml").write_text("format: tum\n")
    return folder


class Joined(unittest.TestCase):
    def setUp(self):
        self.temp = tempfile.TemporaryDirectory()
        self.addCleanup(self.temp.cleanup)
        self.dir = pathlib.Path(self.temp.name)
        a, b = write_capture(self.dir / "a", 0), write_capture(self.dir / "b", 5)
        self.capture = joined.joined([(a, range(2, 5)), (b, range(6, 8))], self.dir / "both")

    def test_frames_follow_each_other_with_their_poses(self):
        files = [line.split()[1] for line in (self.capture / "rgb.txt").read_text().splitlines()]
        self.assertEqual([(self.capture / file).read_text() for file in files],
                         ["a rgb 2", "a rgb 3", "a rgb 4", "b rgb 6", "b rgb 7"])
        rows = [list(map(float, line.split())) for line in (self.capture / "groundtruth.txt").read_text().splitlines()]
        for row, x in zip(rows, (0.2, 0.3, 0.4, 5.6, 5.7)):
            self.assertAlmostEqual(row[1], x)
        steps = [after[0] - before[0] for before, after in zip(rows, rows[1:])]
        self.assertTrue(all(abs(step - joined.INTERVAL_S) < 1e-5 for step in steps))

    def test_ties_are_what_is_measured_across_the_join(self):
        track = self.dir / "map" / "track"
        track.mkdir(parents=True)
        (track / "frames.json").write_text(json.dumps({
            "frames": [{"frame": k, "status": "lost" if k == 3 else "tracked"} for k in range(5)],
            "composed_edges": [[2, 3]]}))
        (track / "odometry.g2o").write_text("".join(
            f"EDGE_SE3:QUAT {i} {j} {x} 0 0 0 0 0 1 " + "0 " * 21 + "\n"
            for i, j, x in ((0, 1, 0.1), (2, 3, 0.1), (1, 3, 5.3), (2, 4, 5.5))))
        found, lost = joined.ties(self.capture, self.dir / "map", 3)
        self.assertEqual(lost, [3])
        self.assertEqual([tie[:2] for tie in found], [(1, 3), (2, 4)])
        self.assertEqual([joined.is_wrong(tie, "leap") for tie in found], [False, True])
        self.assertEqual([joined.is_wrong(tie, "other") for tie in found], [True, True])

    def test_objects_of_both_pieces_are_of_two_rooms_unless_something_ties_them(self):
        self.assertIsNone(joined.mixed(self.dir / "map", 3, False))
        loops = self.dir / "map" / "loops"
        loops.mkdir(parents=True)
        rows = [{"views": [{"frame": frame} for frame in frames]} for frames in ((0, 2), (1, 3), (3, 4), (2, 4, 3))]
        (loops / "objects.json").write_text(json.dumps({"objects": rows}))
        for edges, count in (([], 2), ([{"i": 0, "j": 2}], 2), ([{"i": 2, "j": 4}], 0)):
            (loops / "loops.json").write_text(json.dumps({"edges": edges}))
            self.assertEqual(joined.mixed(self.dir / "map", 3, False), count)
        self.assertEqual(joined.mixed(self.dir / "map", 3, True), 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
