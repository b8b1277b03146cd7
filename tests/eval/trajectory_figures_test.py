#!/usr/bin/env python3
"""`deepslam eval trajectory` against ATE and RPE computed a second time with 4 x 4 matrices in numpy.

    trajectory_figures_test.py DEEPSLAM
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import python_packages  # noqa: E402

[np] = python_packages.need("numpy")

DEEPSLAM = sys.argv[1]


def matrix(row):
    x, y, z, w = row[4:] / np.linalg.norm(row[4:])
    pose = np.eye(4)
    pose[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    pose[:3, 3] = row[1:4]
    return pose


def walk(random, count):
    """Rows of a TUM file: a random walk of places, rotations at random."""
    rows = np.zeros((count, 8))
    rows[:, 0] = np.arange(count) / 30
    rows[:, 1:4] = np.cumsum(random.normal(0, 0.05, (count, 3)), axis=0)
    rows[:, 4:] = [0.1, -0.2, 0.3, 0.9] + np.cumsum(random.normal(0, 0.03, (count, 4)), axis=0)
    return rows


def statistics(values):
    return {"rmse": np.sqrt(np.mean(values ** 2)), "mean": np.mean(values), "median": np.median(values), "max": np.max(values)}


def ate(estimate, truth):
    a, b = estimate[:, 1:4], truth[:, 1:4]
    u, _, vt = np.linalg.svd((b - b.mean(0)).T @ (a - a.mean(0)))
    rotation = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return np.linalg.norm((a - a.mean(0)) @ rotation.T - (b - b.mean(0)), axis=1)


def rpe(estimate, truth, delta):
    moves, turns = [], []
    for i in range(len(truth) - delta):
        true, ours = (np.linalg.inv(matrix(t[i])) @ matrix(t[i + delta]) for t in (truth, estimate))
        off = np.linalg.inv(true) @ ours
        moves.append(np.linalg.norm(off[:3, 3]))
        # Of the skew part as well: the trace alone is blind to small angles.
        sine = np.linalg.norm([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]]) / 2
        turns.append(np.degrees(np.arctan2(sine, (np.trace(off[:3, :3]) - 1) / 2)))
    return np.array(moves), np.array(turns)


class TrajectoryFigures(unittest.TestCase):
    def test_equal_those_of_matrices(self):
        random = np.random.default_rng(3)
        truth = walk(random, 200)
        estimate = truth.copy()
        estimate[:, 1:4] += random.normal(0, 0.02, (200, 3))
        estimate[:, 4:] += random.normal(0, 0.01, (200, 4))
        # Elsewhere in the world, and some poses are missing.
        far = matrix(np.array([0, 3, -7, 2, 0.5, 0.5, -0.5, 0.5]))
        estimate[:, 1:4] = estimate[:, 1:4] @ far[:3, :3].T + far[:3, 3]
        x, y, z, w = (estimate[:, 4:] / np.linalg.norm(estimate[:, 4:], axis=1)[:, None]).T
        a, b, c, d = 0.5, 0.5, -0.5, 0.5
        estimate[:, 4:] = np.stack([d * x + a * w + b * z - c * y, d * y - a * z + b * w + c * x,
                                    d * z + a * y - b * x + c * w, d * w - a * x - b * y - c * z], axis=1)
        kept = random.random(200) > 0.1
        estimate = estimate[kept]
        for rows in (estimate, truth):
            rows[:, 4:] /= np.linalg.norm(rows[:, 4:], axis=1)[:, None]
        with tempfile.TemporaryDirectory() as folder:
            files = [pathlib.Path(folder) / name for name in ("estimate.tum", "truth.tum")]
            for file, rows in zip(files, (estimate, truth)):
                np.savetxt(file, rows, fmt="%.17g")
            for delta in (1, 10):
                done = subprocess.run([DEEPSLAM, "eval", "trajectory", *files, "--rpe-delta", str(delta)], capture_output=True,
                                      text=True, check=True)
                found = json.loads(done.stdout)
                self.assertIn("evo-ate-rpe", found["protocol"])
                self.assertEqual(found["num_scored"], kept.sum())
                moves, turns = rpe(estimate, truth[kept], delta)
                for kind, values in (("ate_m", ate(estimate, truth[kept])), ("rpe_m", moves), ("rpe_deg", turns)):
                    for name, value in statistics(values).items():
                        self.assertAlmostEqual(found[kind][name], value, 9, f"{kind} {name}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
