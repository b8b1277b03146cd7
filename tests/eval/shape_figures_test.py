#!/usr/bin/env python3
"""IoU and Chamfer distance by Pix3D's protocol, computed a second time in a few lines of numpy.

    shape_figures_test.py SHAPE_FIGURES
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

PROGRAM = sys.argv[1]
THRESHOLDS = np.arange(0.01, 0.5, 0.01)


def normalised(volume):
    if volume.shape[0] > 100:
        n = volume.shape[0] // 4
        volume = volume.reshape(n, 4, n, 4, n, 4).max(axis=(1, 3, 5))
    inside = np.argwhere(volume >= 0.1)
    low, high = inside.min(axis=0), inside.max(axis=0)
    side = (high - low).max()
    weights = []
    for last in high - low:
        x = last / 2 - side / 2 + side * np.arange(32) / 31
        weight = np.maximum(0, 1 - np.abs(x[:, None] - np.arange(last + 1)))
        weights.append(weight * ((x >= -1e-9) & (x <= last + 1e-9))[:, None])
    box = volume[tuple(slice(a, b + 1) for a, b in zip(low, high))]
    return np.einsum("ai,bj,ck,ijk->abc", *weights, box, optimize=True)


def iou(a, b, threshold):
    return np.sum((a > threshold) & (b > threshold)) / np.sum((a > threshold) | (b > threshold))


def chamfer(a, b):
    distance = np.linalg.norm(a[:, None] - b[None], axis=2)
    return distance.min(axis=1).mean() + distance.min(axis=0).mean()


def surface_points(volume, random):
    """Where the grid's edges cross 0.1, 1024 of them, box centred, longest side 1."""
    points = []
    for axis in range(3):
        ends = [np.take(volume, range(i, volume.shape[axis] - 1 + i), axis) for i in (0, 1)]
        at = np.argwhere((ends[0] >= 0.1) != (ends[1] >= 0.1))
        first, second = (end[tuple(at.T)] for end in ends)
        crossing = at.astype(float)
        crossing[:, axis] += (0.1 - first) / (second - first)
        points.append(crossing)
    points = random.permutation(np.concatenate(points))[:1024]
    low, high = points.min(axis=0), points.max(axis=0)
    return (points - (low + high) / 2) / (high - low).max()


def chair():
    solid = np.zeros((64, 64, 64))
    solid[9:52, 12:49, 24:30] = 1
    solid[9:14, 12:49, 30:61] = 1
    for i in (9, 47):
        for j in (12, 44):
            solid[i:i + 5, j:j + 5, 3:24] = 1
    return solid


def table():
    solid = np.zeros((64, 64, 64))
    solid[5:38, 2:63, 40:45] = 1
    for i in (7, 31):
        for j in (5, 55):
            solid[i:i + 4, j:j + 4, 8:40] = 1
    return solid


def blob(size, seed):
    """Smooth values in [0, 1], as a network's decoder gives them."""
    random = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(*[np.arange(size)] * 3, indexing="ij"), axis=-1) / size
    value = np.zeros((size, size, size))
    for centre in random.uniform(0.3, 0.7, (6, 3)):
        value += np.exp(-np.sum((grid - centre) ** 2, axis=-1) / random.uniform(0.004, 0.02))
    return np.clip(value, 0, 1)


class ShapeFigures(unittest.TestCase):
    def figures(self, a, b):
        with tempfile.TemporaryDirectory() as folder:
            files = [pathlib.Path(folder) / name for name in "ab"]
            for file, volume in zip(files, (a, b)):
                volume.astype("<f4").tofile(file)
            return json.loads(subprocess.run([PROGRAM, *files], capture_output=True, text=True, check=True).stdout)

    def assert_equal(self, a, b):
        found = self.figures(a, b)
        ours, theirs = normalised(a.astype("<f4").astype(float)), normalised(b.astype("<f4").astype(float))
        compared = 0
        for threshold, value in zip(THRESHOLDS, found["iou"]):
            # Where a sample is the threshold itself, the last bit decides.
            if min(np.abs(v - threshold).min() for v in (ours, theirs)) < 1e-6:
                continue
            self.assertAlmostEqual(value, iou(ours, theirs, threshold), 12, f"threshold {threshold}")
            compared += 1
        self.assertGreater(compared, 35)
        points = [np.array(found[name]) for name in ("points_a", "points_b")]
        self.assertAlmostEqual(found["chamfer"], chamfer(*points), 9)
        for p in points:
            self.assertEqual(p.shape, (1024, 3))
        # Points of our own: the same distance but for which points were drawn.
        random = np.random.default_rng(1)
        own = np.mean([chamfer(surface_points(a, random), surface_points(b, random)) for _ in range(4)])
        self.assertLess(abs(found["chamfer"] - own), 0.08 * own + 0.003, f"{found['chamfer']} and {own}")

    def test_furniture(self):
        self.assert_equal(chair(), table())

    def test_values_between_0_and_1(self):
        self.assert_equal(blob(48, 1), blob(33, 2))
        self.assert_equal(blob(64, 3), chair())

    def test_large_volumes_are_pooled(self):
        fine = blob(128, 4)
        found = self.figures(fine, blob(50, 5))["iou"]
        theirs = normalised(blob(50, 5).astype("<f4").astype(float))
        ours = normalised(fine.astype("<f4").astype(float))
        for n in (4, 20, 40):
            self.assertAlmostEqual(found[n], iou(ours, theirs, THRESHOLDS[n]), 3)

    def test_a_shape_with_itself(self):
        found = self.figures(chair(), chair())
        self.assertEqual(found["iou"], [1] * 49)
        self.assertEqual(found["chamfer"], 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
