#!/usr/bin/env python3
"""How well the frames of a capture agree with each other under given poses, without a truth.

    path_agreement.py CAPTURE POSES.tum [POSES.tum ...] [--pairs 1200] [--seed 0]

CAPTURE as for compare_open3d.py. Points of one frame (every eighth row and
column, 0.3 to 3 m) are laid into another by the poses. Of random pairs of frames those count that share 40 % of the points under
all of the poses given. Printed for pairs fewer than 60 frames apart and for the others: pairs, the median distance along the
ray to the depth measured there (of those within 15 cm), the share within 2 cm, and the pairs' mean absolute median with its sign,
which noise does not feed. Needs numpy and opencv-python.
"""
import argparse
import pathlib

from compare_open3d import read_capture

PARSER = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
PARSER.add_argument("capture")
PARSER.add_argument("poses", nargs="+")
PARSER.add_argument("--pairs", type=int, default=1200)
PARSER.add_argument("--seed", type=int, default=0)
ARGUMENTS = PARSER.parse_args()  # before the imports, so that the help needs nothing installed

import cv2  # noqa: E402
import numpy as np  # noqa: E402

NEAR_FRAMES, STEP_PX, GATE_M, CLOSE_M = 60, 8, 0.15, 0.02
LEAST_SHARED = 0.4


class Capture:
    def __init__(self, folder):
        number, frames = read_capture(pathlib.Path(folder))
        self.focal, self.middle = np.array([number["fx"], number["fy"]]), np.array([number["cx"], number["cy"]])
        self.units_per_m = number["depth_units_per_m"]
        self.times, self.files, self.kept = np.array([time for time, _, _ in frames]), [depth for _, _, depth in frames], {}

    def depth_m(self, n):
        if n not in self.kept:
            self.kept[n] = cv2.imread(str(self.files[n]), cv2.IMREAD_UNCHANGED).astype(np.float32) / self.units_per_m
        return self.kept[n]

    def points(self, n):
        depth_m = self.depth_m(n)
        v, u = np.mgrid[STEP_PX // 2:depth_m.shape[0]:STEP_PX, STEP_PX // 2:depth_m.shape[1]:STEP_PX]
        z = depth_m[v, u]
        known = (z > 0.3) & (z < 3)
        pixels = np.stack([u[known], v[known]])
        rays = (pixels - self.middle[:, None]) / self.focal[:, None]
        return np.vstack([rays * z[known], z[known]])


def rotation(x, y, z, w):
    x, y, z, w = np.array([x, y, z, w]) / np.linalg.norm([x, y, z, w])
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def poses_at(file, times):
    """World-from-camera (rotation, translation) nearest in time."""
    rows = np.array([[float(x) for x in line.split()] for line in open(file, encoding="utf-8") if not line.startswith("#")])
    nearest = [rows[np.argmin(abs(rows[:, 0] - t))] for t in times]
    return [(rotation(*row[4:8]), row[1:4]) for row in nearest]


def residuals(capture, poses, i, j, points):
    """Along the rays of frame j, where both have depth."""
    (r_i, t_i), (r_j, t_j) = poses[i], poses[j]
    p = r_j.T @ (r_i @ points + (t_i - t_j)[:, None])
    depth_m = capture.depth_m(j)
    ahead = p[2] > 0.3
    at = np.round(p[:2] / np.where(ahead, p[2], 1) * capture.focal[:, None] + capture.middle[:, None]).astype(int)
    inside = ahead & (at[0] >= 0) & (at[1] >= 0) & (at[0] < depth_m.shape[1]) & (at[1] < depth_m.shape[0])
    measured = depth_m[at[1, inside], at[0, inside]]
    return (p[2, inside] - measured)[measured > 0]


def main():
    capture = Capture(ARGUMENTS.capture)
    paths = [poses_at(file, capture.times) for file in ARGUMENTS.poses]
    random = np.random.default_rng(ARGUMENTS.seed)
    found = [{"near": [], "far": []} for _ in paths]
    for _ in range(ARGUMENTS.pairs):
        i, j = (int(n) for n in random.integers(0, len(capture.files), 2))
        if abs(i - j) < 5:
            continue
        points = capture.points(i)
        each = [residuals(capture, path, i, j, points) for path in paths]
        if min(len(r) for r in each) < max(1, LEAST_SHARED * points.shape[1]):
            continue
        for figures, r in zip(found, each):
            r = r[abs(r) < GATE_M]
            if len(r):
                figures["near" if abs(i - j) < NEAR_FRAMES else "far"].append(
                    (np.median(abs(r)), np.mean(abs(r) < CLOSE_M), abs(np.median(r))))
    for file, figures in zip(ARGUMENTS.poses, found):
        for name, rows in figures.items():
            if rows:
                median_m, close, bias_m = np.mean(rows, 0)
                print(f"{file} {name}: {len(rows)} pairs, median {1000 * median_m:.1f} mm, within 2 cm {close:.3f}, "
                      f"median with its sign {1000 * bias_m:.1f} mm")


if __name__ == "__main__":
    main()
