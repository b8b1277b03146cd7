#!/usr/bin/env python3
"""Recall and precision of a finished workspace's object boxes against a capture's true boxes (objects.json).

    scripts/experiments/boxes.py WORKSPACE CAPTURE

The map is laid onto the capture's world by its path and groundtruth.txt (rotation about the vertical and translation).
Boxes are matched by the intersection over union of upright boxes, greatest first, each once. Prints a line per true
object, and recall at 0.25 and 0.5, the share that also has the right class, and the share of mapped objects that match.
"""
import argparse
import csv
import json
import math
import pathlib
import sys

MAX_STAMP_S = 0.02  # between a frame of the map's path and one of the truth


def read_tum(path):
    rows = (line.split() for line in path.read_text().splitlines() if line and line[0] != "#")
    return {float(row[0]): tuple(map(float, row[1:4])) for row in rows}


def level_transform(estimated, truth):
    """Yaw and translation that lay the estimated path onto the true one in the least squares sense."""
    stamps = sorted(truth)
    pairs = []
    for stamp, place in estimated.items():
        nearest = min(stamps, key=lambda other: abs(other - stamp))
        if abs(nearest - stamp) <= MAX_STAMP_S:
            pairs.append((place, truth[nearest]))
    if not pairs:
        sys.exit("boxes: no frame of the map's path has a true pose within 0.02 s")
    mean = [[sum(pair[side][axis] for pair in pairs) / len(pairs) for axis in range(3)] for side in range(2)]
    cross = dot = 0.0
    for a, b in pairs:
        ax, ay = a[0] - mean[0][0], a[1] - mean[0][1]
        bx, by = b[0] - mean[1][0], b[1] - mean[1][1]
        cross += ax * by - ay * bx
        dot += ax * bx + ay * by
    yaw = math.atan2(cross, dot)
    c, s = math.cos(yaw), math.sin(yaw)
    x, y, z = mean[0]
    return yaw, (mean[1][0] - c * x + s * y, mean[1][1] - s * x - c * y, mean[1][2] - z)


def rectangle(x, y, half_x, half_y, yaw):
    c, s = math.cos(yaw), math.sin(yaw)
    corners = ((-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y))
    return [(x + c * u - s * v, y + s * u + c * v) for u, v in corners]


def area(polygon):
    return 0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(polygon, polygon[1:] + polygon[:1]))


def clip(polygon, window):
    """Sutherland and Hodgman 1974; both convex and counter-clockwise."""
    for a, b in zip(window, window[1:] + window[:1]):
        def side(p):
            return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        kept = []
        for p, q in zip(polygon, polygon[1:] + polygon[:1]):
            inside_p, inside_q = side(p) >= 0, side(q) >= 0
            if inside_p:
                kept.append(p)
            if inside_p != inside_q:
                t = side(p) / (side(p) - side(q))
                kept.append((p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])))
        polygon = kept
        if not polygon:
            return []
    return polygon


def overlap(a, b):
    height = max(0.0, min(a["top"], b["top"]) - max(a["bottom"], b["bottom"]))
    common = clip(a["outline"], b["outline"])
    shared = height * area(common) if common else 0.0
    volumes = sum(area(box["outline"]) * (box["top"] - box["bottom"]) for box in (a, b))
    return shared / (volumes - shared) if volumes > shared else 0.0


def true_boxes(capture):
    boxes = []
    for entry in json.loads((capture / "objects.json").read_text())["objects"]:
        x, y, z = entry["center_m"]
        half_x, half_y, half_z = entry["half_extent_m"]
        boxes.append({"class": entry["class"], "name": entry.get("source_class", entry["class"]),
                      "outline": rectangle(x, y, half_x, half_y, entry["yaw_rad"]),
                      "bottom": z - half_z, "top": z + half_z})
    return boxes


def mapped_boxes(workspace, yaw, translation):
    c, s = math.cos(yaw), math.sin(yaw)
    boxes = []
    with (workspace / "export" / "objects.csv").open(newline="", encoding="utf-8") as rows:
        for row in csv.DictReader(rows):
            x, y, z = (float(row[key]) for key in ("x_m", "y_m", "z_m"))
            depth, width, height = (float(row[key]) for key in ("depth_m", "width_m", "height_m"))
            place = (c * x - s * y + translation[0], s * x + c * y + translation[1])
            heading = math.radians(float(row["heading_deg"])) + yaw
            boxes.append({"class": row["class"], "name": row["name"],
                          "outline": rectangle(*place, depth / 2, width / 2, heading),
                          "bottom": z + translation[2] - height / 2, "top": z + translation[2] + height / 2})
    return boxes


def match(truth, mapped):
    pairs = sorted(((overlap(t, m), i, j) for i, t in enumerate(truth) for j, m in enumerate(mapped)), reverse=True)
    matched, used = {}, set()
    for iou, i, j in pairs:
        if iou > 0 and i not in matched and j not in used:
            matched[i] = (j, iou)
            used.add(j)
    return matched


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=pathlib.Path)
    parser.add_argument("capture", type=pathlib.Path)
    options = parser.parse_args()
    workspace, capture = options.workspace, options.capture
    for needed in (workspace / "optimize" / "trajectory.tum", workspace / "export" / "objects.csv",
                   capture / "objects.json", capture / "groundtruth.txt"):
        if not needed.is_file():
            sys.exit(f"boxes: {needed} is missing: a finished workspace and a capture with true boxes are needed")
    yaw, translation = level_transform(read_tum(workspace / "optimize" / "trajectory.tum"),
                                       read_tum(capture / "groundtruth.txt"))
    truth, mapped = true_boxes(capture), mapped_boxes(workspace, yaw, translation)
    matched = match(truth, mapped)
    for i, box in enumerate(truth):
        j, iou = matched.get(i, (None, 0.0))
        print(f"{box['name']:16} {box['class']:10} {iou:.2f} {mapped[j]['name'] if j is not None else '-'}")
    found = {i for i, (_, iou) in matched.items() if iou >= 0.25}
    well = sum(iou >= 0.5 for _, iou in matched.values())
    right = sum(mapped[matched[i][0]]["class"] == truth[i]["class"] for i in found)
    print(f"recall at 0.25 {len(found) / len(truth):.2f}, at 0.5 {well / len(truth):.2f}, right class "
          f"{right / len(truth):.2f}; precision {len(found) / max(1, len(mapped)):.2f} of {len(mapped)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
