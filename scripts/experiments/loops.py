#!/usr/bin/env python3
"""Small rooms walked round once and a bit, many seeds: are loops closed, are wrong ones kept out, do duplicates stay?

    scripts/experiments/loops.py [--seeds 0-49] [--work out/loops] [--modes default,paper,drifted] [-- RUN OPTIONS]

Every seed is a room of its own (320 x 240 pixels, 160 frames); in odd ones the same two chairs stand twice, in the
same arrangement. Each capture is reconstructed with the defaults, with configs/paper.yaml, frame-to-frame tracking
(objects detected in keyframes alone, to save time), and by poses of its own that drift, furniture coming back 0.2 to
0.5 m off, with loops by objects alone (what is tracked drifts too little here to ask for them; objects are found by
votes then, as the surface of such a path shows things twice in each other), up to the optimised graph. Against the truth it counts: revisits closed (a loop of either kind, or at least two objects re-identified),
wrong loops (a keyframe loop off by more than 10 cm or 5 deg, a merge of different objects), objects whose views show
two, duplicates left (two objects of the map that are one), and ATE of tracking alone, behind the path's refinement
(which closes rooms of few keyframes already), and at the end. Results lie in --work as one JSON per seed and mode and
are used again; the table goes to stdout. Needs nothing beyond Python 3.
"""
import itertools
import json
import math
import os
import random
import shutil
import sys

import seeded
from seeded import ROOT

CHAIRS = ["Blend Swap CC-0#chair2", "Blend Swap CC-0#chairWithCushion", "Scopia#chair", "Scopia#kids_desk_chair",
          "Blend Swap CC-0#oakChair", "Scopia#armchair2", "Scopia#tubular_chair", "Blend Swap CC-BY#chair4"]
TABLES = ["Scopia#table-with-leaning-feet", "Kator Legaz#folding-table", "Scopia#kids_wooden_desk"]
# Against the walls: class, product, depth and width (m).
STORAGE = [("cabinet", "Blend Swap CC-0#highCabinet", 0.61, 0.60), ("shelf", "Blend Swap CC-0#bookcase", 0.37, 0.92),
           ("shelf", "Kator Legaz#full-bookcase", 0.35, 0.90), ("cabinet", "Blend Swap CC-BY#wardrobe", 0.68, 0.92),
           ("cabinet", "Blend Swap CC-BY#dresserWithDrawers", 0.52, 1.61), ("shelf", "Scopia#kids_shelves", 0.42, 1.01),
           ("cabinet", "Blend Swap CC-BY#kitchenLowerCabinet", 0.62, 0.98), ("shelf", "Kator Legaz#utility-shelving", 0.30, 0.60)]
LAPS, FRAMES = 1.25, 160
MODES = {"default": [],
         "paper": ["--config", str(ROOT / "configs/paper.yaml"), "--set", "detect.frames=keyframes"],
         "drifted": ["--set", "track.poses=capture", "--set", "loops.appearance.enabled=false",
                     "--set", "associate.method=votes", "--set", "detect.frames=keyframes"]}
WRONG_M, WRONG_DEG, SAME_OBJECT_M = 0.10, 5.0, 0.5
DRIFT_M, DRIFT_DEG = (0.10, 0.25), (4.0, 8.0)  # of a lap; what is 2 m off moves by 0.14 m for 4 deg


def scene(seed, frames=FRAMES, along_walls=True):
    """The room's YAML. Furniture at four places about the middle, the camera on an ellipse inside, looking outwards."""
    draw = random.Random(seed)
    x, y = draw.uniform(4.8, 5.8), draw.uniform(4.4, 5.4)
    places = [(sx * (x / 2 - 1.15), sy * (y / 2 - 1.05)) for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    draw.shuffle(places)
    chairs = draw.sample(CHAIRS, 6)
    gap, turns = draw.uniform(0.75, 0.9), [draw.uniform(-40, 40) for _ in range(8)]
    objects = []

    def put(kind, model, place, along, yaw):
        # `along` the wall that the furniture faces away from.
        heading = math.atan2(-place[1], -place[0])
        at = (place[0] - along * math.sin(heading), place[1] + along * math.cos(heading))
        objects.append(f'  - {{class: {kind}, model: "{model}", position_m: [{at[0]:.3f}, {at[1]:.3f}], '
                       f'yaw_deg: {math.degrees(heading) + yaw:.1f}}}')

    for side in (0, 1):
        put("chair", chairs[side], places[0], (side - 0.5) * gap, turns[side])
        if seed % 2:
            put("chair", chairs[side], places[1], (side - 0.5) * gap, turns[side])
        else:
            put("chair", chairs[2 + side], places[1], (side - 0.5) * gap, turns[2 + side])
    put("table", draw.choice(TABLES), places[2], 0, 0)
    put("chair", chairs[4], places[3], -0.4, turns[4])
    put("chair", chairs[5], places[3], 0.4, turns[5])
    for wall, (kind, model, depth, width) in enumerate(draw.sample(STORAGE, 4)):
        out, along = (x if wall % 2 == 0 else y) / 2 - depth / 2 - 0.02, draw.uniform(-0.4, 0.4)
        sign = 1 if wall < 2 else -1
        at = (sign * out, along) if wall % 2 == 0 else (along, sign * out)
        if not along_walls:
            continue
        objects.append(f'  - {{class: {kind}, model: "{model}", position_m: [{at[0]:.3f}, {at[1]:.3f}], '
                       f'yaw_deg: {(180, 270, 0, 90)[wall]}}}')
    around = [2 * math.pi * k / 8 for k in range(8)]
    start = draw.uniform(0, 2 * math.pi)
    points = ", ".join(f"[{0.6 * math.cos(a + start):.3f}, {0.5 * math.sin(a + start):.3f}, "
                       f"{draw.uniform(1.4, 1.6):.3f}]" for a in around)
    looks = ", ".join(f"[{(x / 2 - 0.9) * math.cos(a + start):.3f}, {(y / 2 - 0.8) * math.sin(a + start):.3f}, "
                      f"{draw.uniform(0.35, 0.6):.3f}]" for a in around)
    return f"""seed: {1000 + seed}
frames: {frames}
frames_per_s: 15
camera: {{preset: kinect_v1, width: 320, height: 240, fx: 262.5, fy: 262.5, cx: 159.5, cy: 119.5}}
room:
  size_m: [{x:.2f}, {y:.2f}, 2.6]
  floor: {draw.choice(["wood", "tiles", "carpet"])}
  posters: {draw.randrange(2, 8)}
  ambient: 0.42
lights:
  - {{position_m: [0.8, 0.5, 2.55], side_m: 0.9, power: 2.4}}
  - {{position_m: [-1.0, -0.6, 2.55], side_m: 0.9, power: 2.0}}
openings:
  - {{wall: {draw.choice(["east", "north", "west", "south"])}, from_m: 1.4, width_m: 0.9}}
objects:
{chr(10).join(objects)}
walk:
  closed: true
  laps: {LAPS}
  points_m: [{points}]
  look_at_m: [{looks}]
  shake_m: 0.01
  shake_deg: 0.7
"""


# Poses are (rotation as rows, translation).
def pose(quaternion, translation):
    x, y, z, w = quaternion
    return ([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]], list(translation))


def quaternion(rotation):
    """x, y, z, w of a rotation; the largest component first, so that none is divided by nearly nothing."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    squared = [1 + a - e - i, 1 - a + e - i, 1 - a - e + i, 1 + a + e + i]
    products = [[squared[0], b + d, c + g, h - f], [b + d, squared[1], f + h, c - g],
                [c + g, f + h, squared[2], d - b], [h - f, c - g, d - b, squared[3]]]
    row = products[max(range(4), key=lambda k: squared[k])]
    length = math.hypot(*row)
    return [value / length for value in row]


def times(a, b):
    rotation = [[sum(a[0][i][k] * b[0][k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return rotation, [sum(a[0][i][k] * b[1][k] for k in range(3)) + a[1][i] for i in range(3)]


def inverse(a):
    rotation = [[a[0][j][i] for j in range(3)] for i in range(3)]
    return rotation, [-sum(rotation[i][k] * a[1][k] for k in range(3)) for i in range(3)]


def off(a, b):
    """Distance (m) and angle (deg) between two poses."""
    rotation, move = times(inverse(a), b)
    cosine = (rotation[0][0] + rotation[1][1] + rotation[2][2] - 1) / 2
    return math.dist(move, (0, 0, 0)), math.degrees(math.acos(max(-1.0, min(1.0, cosine))))


def of_json(value):
    return pose(value["rotation_xyzw"], value["translation_m"])


def read_tum(path):
    rows = [[float(word) for word in line.split()] for line in path.read_text().splitlines()
            if line.strip() and not line.startswith("#")]
    return [(row[0], pose(row[4:8], row[1:4])) for row in rows]


def read_json(path):
    return json.loads(path.read_text())


def drifted_copy(seed, capture, folder):
    """The capture by links, with poses that turn about the vertical and shift by as much every second, anew for every seed."""
    if (folder / "groundtruth.txt").exists():
        return folder
    draw = random.Random(5000 + seed)
    turn, heading = math.radians(draw.choice((-1, 1)) * draw.uniform(*DRIFT_DEG)), draw.uniform(0, 2 * math.pi)
    shift = draw.uniform(*DRIFT_M)
    shutil.copytree(capture, folder, copy_function=os.link, ignore=shutil.ignore_patterns("groundtruth.txt", "truth"))
    stamped = read_tum(capture / "groundtruth.txt")
    per_lap = LAPS / (stamped[-1][0] - stamped[0][0])
    lines = []
    for time_s, true in stamped:
        laps = (time_s - stamped[0][0]) * per_lap
        sine, cosine = math.sin(laps * turn), math.cos(laps * turn)
        moved = times(([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]],
                       [laps * shift * math.cos(heading), laps * shift * math.sin(heading), 0]), true)
        lines.append(" ".join(f"{value:.9f}" for value in (time_s, *moved[1], *quaternion(moved[0]))))
    (folder / "groundtruth.txt").write_text("\n".join(lines) + "\n")
    return folder


class Truth:
    def __init__(self, capture, workspace):
        self.stamped = read_tum(capture / "groundtruth.txt")
        self.times = {row["frame"]: row["time_s"] for row in read_json(workspace / "track/frames.json")["frames"]}
        self.objects = read_json(capture / "truth/objects.json")["objects"]

    def camera(self, frame):
        return min(self.stamped, key=lambda row: abs(row[0] - self.times[frame]))[1]

    def object_of(self, entry):
        """The true object that a map's object is, by what its best view saw from the true camera; None: none near."""
        views = [view for view in entry["views"] if view["ok"]]
        return self.shown(max(views, key=lambda view: view["inlier_share"])) if views else None

    def objects_of(self, entry):
        """The true objects that its views show."""
        return {self.shown(view) for view in entry["views"] if view["ok"]} - {None}

    def shown(self, view):
        seen = times(self.camera(view["frame"]), of_json(view["camera_from_object"]))[1]

        def distance(k):
            return math.dist(seen[:2], self.objects[k]["translation_m"][:2])

        nearest = min(range(len(self.objects)), key=distance)
        return nearest if distance(nearest) < SAME_OBJECT_M else None


def of_tracklets(loops, rows):
    """By id, what each tracklet saw that was looked for by itself: its views of the object of `rows` that it ended in."""
    kept = {row["merged"]: row["kept"] for row in loops["merges"]}
    known = {row["id"]: row["views"] for row in rows}
    return {tracklet["visit"]: {"views": [view for view in known.get(kept.get(tracklet["visit"], tracklet["visit"]), [])
                                          if tracklet["first"] <= view["frame"] <= tracklet["last"]]}
            for tracklet in loops["visits"]}


def score(capture, workspace, ate):
    truth = Truth(capture, workspace)
    loops = read_json(workspace / "loops/loops.json")
    before = {row["id"]: truth.object_of(row) for row in read_json(workspace / "select/objects.json")["objects"]}
    already = [k for k in before.values() if k is not None]
    rows = read_json(workspace / "loops/objects.json")["objects"]
    after = [truth.object_of(row) for row in rows]
    before.update({key: truth.object_of(tracklet) for key, tracklet in of_tracklets(loops, rows).items()})
    frames = sorted(truth.times)
    first_lap = frames[int(len(frames) / LAPS) - 1]
    reidentified = sum(
        any(m["frame"] <= first_lap // 2 for m in track["members"]) and any(m["frame"] > first_lap for m in track["members"])
        for track in read_json(workspace / "loops/tracks.json")["tracks"])
    appearance = [row for row in loops["appearance"] if row["accepted"]]
    errors = [off(of_json(row["old_from_new"]),
                  times(inverse(truth.camera(row["old_keyframe"])), truth.camera(row["new_keyframe"])))
              for row in appearance]
    constellations = [row for row in loops["constellations"] if row["accepted"] and len(row["pairs"]) > 1]
    known = [k for k in after if k is not None]
    return {
        "appearance": len(appearance),
        "constellations": len(constellations),
        "known_again": reidentified,
        "closed": bool(appearance) or bool(constellations) or reidentified >= 2,
        "wrong_appearance": sum(m > WRONG_M or deg > WRONG_DEG for m, deg in errors),
        "worst_appearance_m": max((m for m, _ in errors), default=0.0),
        "wrong_merges": sum(before.get(row["kept"]) != before.get(row["merged"]) for row in loops["merges"]),
        "merges": len(loops["merges"]),
        "mixed": sum(len(truth.objects_of(row)) > 1 for row in rows),
        "objects": len(after),
        "duplicates_before": len(already) - len(set(already)),
        "duplicates": len(known) - len(set(known)),
        **ate,
    }


def rendered(args, seed):
    """The capture of the seed's room; None where it cannot be rendered (its log says why)."""
    capture = args.work / "captures" / f"{seed:03d}"
    if (capture / "groundtruth.txt").exists():
        return capture
    file = args.work / "scenes" / f"{seed:03d}.yaml"
    file.write_text(scene(seed))
    return capture if seeded.call(args, f"{seed:03d}", "synth", file, "-o", capture) else None


class Driver:
    def __init__(self, args):
        self.args = args

    def call(self, name, *command):
        return seeded.call(self.args, name, *command)

    def ate(self, name, estimate, capture):
        file = self.args.work / "results" / "ate.json"
        if not self.call(name, "eval", "trajectory", estimate, capture / "groundtruth.txt", "--json", file):
            return None
        return read_json(file)["ate_m"]["rmse"]

    def seed(self, seed, mode):
        """The figures of one seed and mode; None where something failed (its log says what)."""
        name = f"{seed:03d}.{mode}"
        result = self.args.work / "results" / f"{name}.json"
        if result.exists():
            return read_json(result)
        capture = rendered(self.args, seed)
        if capture is None:
            return None
        workspace = self.args.work / "workspaces" / name
        shown = drifted_copy(seed, capture, self.args.work / "captures" / name) if mode == "drifted" else capture
        if not self.call(name, "run", shown, "-o", workspace, "--progress", "none", "--threads", self.args.threads,
                         *MODES[mode], *self.args.run_options, "--until", "optimize"):
            return None
        figures = score(capture, workspace, {
            "ate_before": self.ate(name, workspace / "track/as_tracked.tum", capture),
            "ate_path": self.ate(name, workspace / "track/trajectory.tum", capture),
            "ate_after": self.ate(name, workspace / "optimize/trajectory.tum", capture)})
        result.write_text(json.dumps({"seed": seed, "mode": mode, **figures}, indent=1) + "\n")
        return read_json(result)


def median(values):
    ordered = sorted(values)
    return ordered[len(ordered) // 2] if ordered else float("nan")


def table(rows, modes):
    lines = ["| tracking | rooms | captures | closed | loops by appearance | constellations | wrong loops | wrong merges | "
             "two in one | duplicates before, left | ATE tracked | path refined | after | worst after | above tracked |", "|" + "---|" * 15]
    for mode in modes:
        for repeated in (False, True):
            group = [row for row in rows if row["mode"] == mode and bool(row["seed"] % 2) == repeated]
            if not group:
                continue

            def total(key):
                return sum(row[key] for row in group)

            lines.append(
                f"| {mode} | {'two chairs twice' if repeated else 'all chairs differ'} | {len(group)} | {total('closed')} | "
                f"{total('appearance')} | {total('constellations')} | {total('wrong_appearance')} | {total('wrong_merges')} | "
                f"{total('mixed')} | "
                f"{total('duplicates_before')}, {total('duplicates')} | "
                f"{100 * median([row['ate_before'] for row in group]):.2f} cm | "
                f"{100 * median([row['ate_path'] for row in group]):.2f} cm | "
                f"{100 * median([row['ate_after'] for row in group]):.2f} cm | "
                f"{100 * max(row['ate_after'] for row in group):.2f} cm | "
                f"{sum(row['ate_after'] > row['ate_before'] for row in group)} |")
    return "\n".join(lines)


def main():
    args = seeded.arguments(__doc__, "out/loops", "0-49", "modes", MODES)
    driver = Driver(args)
    rows, failed = seeded.collect(args, driver.seed, itertools.product(args.seeds, args.modes))
    print(table(rows, args.modes))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
