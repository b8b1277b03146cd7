#!/usr/bin/env python3
"""How far the walls of a map lie from the surface that was measured: planes fitted to the raw depth of single frames.

    wall_planes.py WORKSPACE CAPTURE [--every 20] [--max-depth 3.5]

Nothing of the program is used but its results: walls of export/map.json and poses of optimize/trajectory.tum. CAPTURE is in TUM layout
and has poses of its own (groundtruth.txt). Pixels of every 20th frame (every sixth row and column, up to 3.5 m) become points in the
map's world twice: by the map's poses, and by the capture's, which are laid on the map's by the mean motion between the two. To each
wall belong points within 25 cm of its rectangle whose surface faces as it does, within 30 degrees. Their plane is the one that most
of them lie on within 2 cm (RANSAC, 500 draws of a fixed seed), fitted again by least squares over these. Printed per wall and poses:
points, the share of them on the plane, its offset from the wall at the middle of these points (towards the room: positive), the angle
between both, the part of it seen from above, the deviation of the points from their plane, and the heights that they were seen at: of
a strip the tilt says little. Needs numpy and pillow.
"""
import argparse
import json
import pathlib
import re

PARSER = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
PARSER.add_argument("workspace", type=pathlib.Path)
PARSER.add_argument("capture", type=pathlib.Path)
PARSER.add_argument("--every", type=int, default=20)
PARSER.add_argument("--max-depth", type=float, default=3.5)
ARGUMENTS = PARSER.parse_args()  # before the imports, so that the help needs nothing installed

import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

STEP_PX, NEAR_M, ON_PLANE_M, MAX_TURN_DEG, DRAWS = 6, 0.25, 0.02, 30, 500
FEWEST_POINTS = 500


def rotation(x, y, z, w):
    x, y, z, w = np.array([x, y, z, w]) / np.linalg.norm([x, y, z, w])
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def read_lines(file):
    return [line.split() for line in file.read_text(encoding="utf-8").splitlines() if line.strip() and not line.startswith("#")]


def read_poses(file):
    """World-from-camera (rotation, translation) by time to the millisecond."""
    return {round(float(row[0]), 3): (rotation(*map(float, row[4:8])), np.array(row[1:4], float)) for row in read_lines(file)}


def mean_motion(pairs):
    """The motion b_from_a that is the mean over poses (b_from_camera, a_from_camera)."""
    u, _, vt = np.linalg.svd(sum(b[0] @ a[0].T for b, a in pairs))
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return turn, np.mean([b[1] - turn @ a[1] for b, a in pairs], axis=0)


class Camera:
    def __init__(self, capture):
        text = (capture / "capture.yaml").read_text(encoding="utf-8")
        self.number = {name: float(re.search(rf"\b{name}:\s*([-0-9.]+)", text)[1])
                       for name in ("fx", "fy", "cx", "cy", "depth_units_per_m")}

    def points(self, file):
        """Points in the camera and normals towards it, of pixels whose neighbours have depth as well."""
        z = np.asarray(Image.open(file), dtype=np.float64) / self.number["depth_units_per_m"]
        v, u = np.mgrid[0:z.shape[0]:STEP_PX, 0:z.shape[1]:STEP_PX]
        z = z[::STEP_PX, ::STEP_PX]
        n = self.number
        grid = np.stack([(u - n["cx"]) / n["fx"] * z, (v - n["cy"]) / n["fy"] * z, z], axis=-1)
        across, down = grid[1:-1, 2:] - grid[1:-1, :-2], grid[2:, 1:-1] - grid[:-2, 1:-1]
        normal = np.cross(down, across)
        length = np.linalg.norm(normal, axis=-1)
        measured = (z[1:-1, 2:] > 0) & (z[1:-1, :-2] > 0) & (z[2:, 1:-1] > 0) & (z[:-2, 1:-1] > 0) & (length > 0)
        known = measured & (z[1:-1, 1:-1] > 0.3) & (z[1:-1, 1:-1] < ARGUMENTS.max_depth)
        return grid[1:-1, 1:-1][known], (normal / np.maximum(length, 1e-12)[..., None])[known]


def of_wall(wall, points, normals):
    """Those that may be the wall's, in its frame: along it, towards its room, up."""
    begin, end = np.array(wall["from_m"]), np.array(wall["to_m"])
    along = (end - begin) / np.linalg.norm(end - begin)
    inward = np.array([-along[1], along[0]])
    place = np.column_stack([(points[:, :2] - begin) @ along, (points[:, :2] - begin) @ inward, points[:, 2]])
    near = (place[:, 0] > 0) & (place[:, 0] < np.linalg.norm(end - begin)) & (np.abs(place[:, 1]) < NEAR_M)
    near &= (place[:, 2] > wall["bottom_m"] + 0.1) & (place[:, 2] < wall["top_m"])
    near &= normals[:, :2] @ inward > np.cos(np.radians(MAX_TURN_DEG))
    return place[near]


def plane_of(points):
    """Normal and centre by least squares."""
    centre = points.mean(axis=0)
    return np.linalg.svd(points - centre, full_matrices=False)[2][2], centre


def robust_plane(points):
    """Normal (towards the room), centre of what lies on the plane, which does."""
    draw = np.random.default_rng(0)
    few = points[draw.permutation(len(points))[:4000]]
    best, most = None, -1
    for _ in range(DRAWS):
        a, b, c = few[draw.choice(len(few), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length < 1e-4:
            continue
        count = np.sum(np.abs((few - a) @ normal) < ON_PLANE_M * length)
        if count > most:
            best, most = (normal / length, a), count
    for _ in range(3):
        on = np.abs((points - best[1]) @ best[0]) < ON_PLANE_M
        best = plane_of(points[on])
    normal = best[0] if best[0][1] > 0 else -best[0]
    return normal, best[1], on


def row(wall_name, poses_name, wall, cloud):
    place = of_wall(wall, *cloud)
    length = np.linalg.norm(np.subtract(wall["to_m"], wall["from_m"]))
    if len(place) < FEWEST_POINTS:
        return f"| {wall_name} | {length:.2f} | {poses_name} | {len(place)} | too few | | | | | |"
    normal, centre, on = robust_plane(place)
    angle = np.degrees(np.arccos(min(1, normal[1])))
    heading = np.degrees(np.arctan2(normal[0], normal[1]))
    off = (place[on] - centre) @ normal
    low, high = np.percentile(place[on][:, 2], [2, 98])
    return (f"| {wall_name} | {length:.2f} | {poses_name} | {len(place)} | {on.mean():.2f} | {100 * centre[1]:+.1f} cm | "
            f"{angle:.2f} deg | {heading:+.2f} deg | {1000 * off.std():.0f} mm | {low:.2f} to {high:.2f} m |")


def main():
    layout = json.loads((ARGUMENTS.workspace / "export" / "map.json").read_text(encoding="utf-8"))["layout"]
    of_map = read_poses(ARGUMENTS.workspace / "optimize" / "trajectory.tum")
    given = read_poses(ARGUMENTS.capture / "groundtruth.txt")
    turn, move = mean_motion([(of_map[t], given[t]) for t in sorted(of_map.keys() & given.keys())])
    laid = {t: (turn @ pose[0], turn @ pose[1] + move) for t, pose in given.items()}
    off = [np.linalg.norm(of_map[t][1] - laid[t][1]) for t in of_map.keys() & laid.keys()]
    print(f"poses of the map and of the capture differ by {100 * np.sqrt(np.mean(np.square(off))):.1f} cm (rms)\n")
    camera = Camera(ARGUMENTS.capture)
    clouds = {"map's": ([], []), "capture's": ([], [])}
    for time, file in read_lines(ARGUMENTS.capture / "depth.txt")[::ARGUMENTS.every]:
        points, normals = camera.points(ARGUMENTS.capture / file)
        for poses, cloud in zip((of_map, laid), clouds.values()):
            if (pose := poses.get(round(float(time), 3))) is None:
                continue
            cloud[0].append(points @ pose[0].T + pose[1])
            cloud[1].append(normals @ pose[0].T)
    clouds = {name: tuple(map(np.concatenate, cloud)) for name, cloud in clouds.items()}
    print("| wall | length, m | poses | points | on one plane | offset | angle | from above | deviation | seen at |\n" + "|---" * 10 + "|")
    for wall in layout["walls"]:
        for name, cloud in clouds.items():
            print(row(f"wall_{wall['id']:02d}", name, wall, cloud))


if __name__ == "__main__":
    main()
