#!/usr/bin/env python3
"""The graphs that a run writes, as another program reads them: GTSAM.

    written_graph_test.py DEEPSLAM SOLVE_G2O

A rendered room with its objects goes through the program up to the optimised graph. Poses, edges and chi^2 by g2o's
definition, from what GTSAM has read, must be what the program's own reader finds. Skipped (77) without GTSAM.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "support"), str(HERE.parent / "end_to_end")]
import captures  # noqa: E402
import python_packages  # noqa: E402

gtsam, np = python_packages.need("gtsam", "numpy")

DEEPSLAM, SOLVE = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-graph-")
DIR = pathlib.Path(TEMP.name)
OBJECTS_FROM = 100_000_000  # numbers of the objects' vertices


def g2o_error(factor, values):
    """Translation and the quaternion's vector part of z^-1 x_i^-1 x_j."""
    i, j = (values.atPose3(key) for key in factor.keys())
    off = factor.measured().inverse() * i.inverse() * j
    q = off.rotation().toQuaternion()
    return np.concatenate([off.translation(), np.copysign(1, q.w()) * np.array([q.x(), q.y(), q.z()])])


def information(factor):
    """Translation first, as files have it. GTSAM has rotation first."""
    root = factor.noiseModel().R()
    order = [3, 4, 5, 0, 1, 2]
    return (root.T @ root)[np.ix_(order, order)]


def chi2(graph, values):
    factors = [graph.at(k) for k in range(graph.size())]
    return sum(g2o_error(f, values) @ information(f) @ g2o_error(f, values) for f in factors)


class WrittenGraph(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        boxes = DIR / "boxes.json"
        boxes.write_text(json.dumps(captures.true_boxes(DIR / "room")))
        done = captures.deepslam(DEEPSLAM, "run", DIR / "room", "-o", DIR / "run", "--until", "optimize", "--progress", "none",
                                 "--set", "detect.source=file", "--set", f"detect.file={boxes}", "--set",
                                 "propose.retrieval=false", "--set", "detect.frames=all")
        assert done.returncode == 0, done.stderr

    def read(self, name):
        file = DIR / "run" / "optimize" / name
        self.assertIn("#DEEPSLAM_PLANE", file.read_text(), "what g2o has no name for is in the file")
        graph, values = gtsam.readG2o(str(file), True)
        said = subprocess.run([SOLVE, file], check=True, capture_output=True, text=True).stdout.split()
        self.assertEqual((values.size(), graph.size()), (int(said[0]), int(said[1])))
        self.assertAlmostEqual(chi2(graph, values) / float(said[2]), 1, delta=1e-6)
        return graph, values

    def test_chi2_is_the_energy_of_the_terms_between_poses(self):
        """Rotations left over are small, so that g2o's error, by quaternions, and ours, by rotation vectors, agree."""
        terms = json.loads((DIR / "run" / "optimize" / "summary.json").read_text())["terms"]
        energy = sum(term["after"] for term in terms if term["name"] in ("r_io", "r_ij", "loop"))
        self.assertGreater(energy, 0)
        self.assertAlmostEqual(chi2(*self.read("graph.g2o")) / energy, 1, delta=0.02)

    def test_both_files_are_one_graph_at_two_places(self):
        (before, start), (after, end) = (self.read(name) for name in ("graph_before.g2o", "graph.g2o"))
        self.assertEqual(list(start.keys()), list(end.keys()))
        self.assertEqual([before.at(k).keys() for k in range(before.size())], [after.at(k).keys() for k in range(after.size())])
        objects = [key for key in end.keys() if key >= OBJECTS_FROM]
        self.assertEqual(len(objects), len(json.loads((DIR / "run/optimize/objects.json").read_text())["objects"]))
        self.assertGreater(len(objects), 0)

    def test_keyframes_stand_where_the_trajectory_has_them(self):
        _, values = self.read("graph.g2o")
        keyframes = [key for key in values.keys() if key < OBJECTS_FROM]
        poses = captures.read_poses(DIR / "run" / "optimize" / "keyframes.tum")
        self.assertEqual(len(keyframes), len(poses))
        for key, pose in zip(keyframes, poses):
            np.testing.assert_allclose(values.atPose3(key).translation(), pose[:3], atol=1e-6)


if __name__ == "__main__":
    if captures.make_room(DEEPSLAM, DIR / "room") is None:
        print("skipped: sweethome3d-furniture is not installed; scripts/setup.sh installs it", file=sys.stderr)
        sys.exit(python_packages.SKIPPED)
    unittest.main(argv=sys.argv[:1])
