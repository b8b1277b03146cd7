#!/usr/bin/env python3
"""How far the ground that a run saw is from the truth: height of the camera above it and tilt, over its keyframes.

    ground_error.py WORKSPACE CAPTURE [WORKSPACE CAPTURE ...]

CAPTURE holds the true poses in groundtruth.txt (world from camera, floor at z = 0, z up): a capture of `deepslam synth`, or one
with motion capture on the floor. Read are track/frames.json and ground/ground.json of the workspace, as stage `ground` left them.
Printed per workspace: keyframes that saw the ground, of how many; median and largest error of the height in millimetres, with
the median's sign; median and largest tilt in degrees. Plain Python.
"""
import argparse
import bisect
import json
import math
import pathlib
import statistics

MAX_TIME_DIFFERENCE_S = 0.02


def read_truth(file):
    """Times, and per time the camera's height and where it has the world's up."""
    rows = []
    for line in file.read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            time_s, _, _, height_m, x, y, z, w = (float(word) for word in line.split()[:8])
            # The third row of the rotation: z of the world in the camera.
            rows.append((time_s, height_m, (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y))))
    rows.sort()
    return [row[0] for row in rows], rows


def nearest(times, rows, time_s):
    at = bisect.bisect_left(times, time_s)
    row = min(rows[max(0, at - 1):at + 1], key=lambda candidate: abs(candidate[0] - time_s))
    return row if abs(row[0] - time_s) <= MAX_TIME_DIFFERENCE_S else None


def errors(workspace, capture):
    """(keyframes in all, height errors in m, tilts in degrees)."""
    track = json.loads((workspace / "track" / "frames.json").read_text())
    ground = json.loads((workspace / "ground" / "ground.json").read_text())
    times, rows = read_truth(capture / "groundtruth.txt")
    heights_m, tilts_deg = [], []
    for seen in ground["observations"]:
        truth = nearest(times, rows, track["frames"][seen["keyframe"]]["time_s"])
        if truth is None:
            continue
        plane = seen["plane_camera"]
        heights_m.append(plane["d_m"] - truth[1])
        cross = [plane["normal"][(k + 1) % 3] * truth[2][(k + 2) % 3] - plane["normal"][(k + 2) % 3] * truth[2][(k + 1) % 3]
                 for k in range(3)]
        tilts_deg.append(math.degrees(math.asin(min(1.0, math.hypot(*cross)))))
    return len(track["keyframes"]), heights_m, tilts_deg


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="+", metavar="WORKSPACE CAPTURE", type=pathlib.Path)
    paths = parser.parse_args().paths
    if len(paths) % 2:
        parser.error("a capture belongs to each workspace")
    for workspace, capture in zip(paths[::2], paths[1::2]):
        keyframes, heights_m, tilts_deg = errors(workspace, capture)
        if not heights_m:
            print(f"{workspace}: no ground seen")
            continue
        print(f"{workspace}: seen in {len(heights_m)} of {keyframes} keyframes, height off by "
              f"{1000 * statistics.median(heights_m):+.1f} mm (largest {1000 * max(map(abs, heights_m)):.1f}), tilt "
              f"{statistics.median(tilts_deg):.2f} deg (largest {max(tilts_deg):.2f})")


if __name__ == "__main__":
    main()
