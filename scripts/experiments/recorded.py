#!/usr/bin/env python3
"""Long walks whose recorder drifts and whose camera is covered now and then: what poses of the recorder are good for.

    scripts/experiments/recorded.py [--seeds 0-4] [--work out/recorded] [--poses track,capture,prior] [-- RUN OPTIONS]

Every seed is a room of its own (as scripts/experiments/loops.py makes them, 320 x 240 pixels) walked round twice in 320
frames. Its poses are those of a VIO as phones have it: they drift by 1 % of the way, to a side that changes slowly, and
turn by 2 degrees a minute, and jitter by half a millimetre a frame. Three intervals of one to two
seconds show nothing: in two of them colour and depth are covered, in one depth alone is missing. Each capture is tracked
with --poses track, capture and prior. The table has the ATE of each, over all frames (those that could not be placed lie
where the path is filled in), and how many frames were placed. Results lie in --work as one JSON per seed and are used
again. Needs nothing beyond Python 3.
"""
import json
import math
import os
import random
import shutil
import struct
import sys
import zlib

import loops
import seeded

FRAMES, LAPS = 320, 2
WIDTH, HEIGHT = 320, 240
POSES = ["track", "capture", "prior"]
DRIFT_SHARE, TURN_DEG_PER_MIN = 0.01, 2.0  # of the way; what visual-inertial odometry drifts by
SIDE_DEG = 8                               # by which the side that it drifts to changes from frame to frame
JITTER_M, JITTER_DEG = 0.0005, 0.02        # from frame to frame
INTERVALS = 3
INTERVAL_FRAMES = (15, 30)


def png(values, bits, channels):
    """A PNG file of one value for every pixel."""
    pixel = struct.pack(">H", values[0]) if bits == 16 else bytes(values)
    rows = (b"\0" + pixel * WIDTH) * HEIGHT

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", WIDTH, HEIGHT, bits, 2 if channels == 3 else 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def turned(axis_angle_deg):
    angle = math.radians(math.hypot(*axis_angle_deg))
    if angle == 0:
        return loops.pose((0, 0, 0, 1), (0, 0, 0))
    axis = [math.radians(value) / angle for value in axis_angle_deg]
    return loops.pose([value * math.sin(angle / 2) for value in axis] + [math.cos(angle / 2)], (0, 0, 0))


def drifting(stamped, draw):
    """The poses as a recorder has them, in a world of its own."""
    turn_deg_per_s = draw.choice((-1, 1)) * TURN_DEG_PER_MIN / 60
    side_deg = draw.uniform(0, 360)
    recorded = [(stamped[0][0], loops.times(turned((0, 0, draw.uniform(-180, 180))), stamped[0][1]))]
    for (time_s, before), (next_s, after) in zip(stamped, stamped[1:]):
        step = loops.times(loops.inverse(before), after)
        # About the vertical, which a recorder knows by gravity: the camera's y axis, nearly.
        jitter = [draw.gauss(0, JITTER_DEG) for _ in range(3)]
        jitter[1] += turn_deg_per_s * (next_s - time_s)
        rotation, place = loops.times(loops.times(recorded[-1][1], step), turned(jitter))
        side_deg += draw.gauss(0, SIDE_DEG)
        drift_m = DRIFT_SHARE * math.hypot(*step[1])
        place[0] += drift_m * math.cos(math.radians(side_deg)) + draw.gauss(0, JITTER_M)
        place[1] += drift_m * math.sin(math.radians(side_deg)) + draw.gauss(0, JITTER_M)
        place[2] += draw.gauss(0, JITTER_M)
        recorded.append((next_s, (rotation, place)))
    return recorded


def hidden_intervals(draw):
    """[first, end) of each, one in every third of the walk, none in its first tenth."""
    third = FRAMES // INTERVALS
    for k in range(INTERVALS):
        length = draw.randint(*INTERVAL_FRAMES)
        yield (first := k * third + draw.randint(FRAMES // 10, third - length - 5)), first + length


def recorded_copy(seed, capture, folder):
    """The capture by links, with the recorder's poses, and images that show nothing; and how many do not."""
    draw = random.Random(7000 + seed)
    intervals = list(hidden_intervals(draw))
    hidden = sum(end - first for first, end in intervals)
    if (folder / "groundtruth.txt").exists():
        return folder, hidden
    shutil.copytree(capture, folder, copy_function=os.link, ignore=shutil.ignore_patterns("groundtruth.txt", "truth"))
    names = {kind: [line.split()[1] for line in (capture / f"{kind}.txt").read_text().splitlines()
                    if line.strip() and not line.startswith("#")] for kind in ("rgb", "depth")}
    for k, (first, end) in enumerate(intervals):
        for frame in range(first, end):
            replaced = {"depth": png([0], 16, 1)}
            if k != 1:
                replaced["rgb"] = png((60, 50, 45), 8, 3)
            for kind, content in replaced.items():
                image = folder / names[kind][frame]
                image.unlink()  # a link to the capture's own
                image.write_bytes(content)
    lines = [" ".join(f"{value:.9f}" for value in (time_s, *pose[1], *loops.quaternion(pose[0])))
             for time_s, pose in drifting(loops.read_tum(capture / "groundtruth.txt"), draw)]
    (folder / "groundtruth.txt").write_text("\n".join(lines) + "\n")
    return folder, hidden


def rendered(args, seed):
    capture = args.work / "captures" / f"{seed:03d}"
    if (capture / "groundtruth.txt").exists():
        return capture
    file = args.work / "scenes" / f"{seed:03d}.yaml"
    scene = loops.scene(seed, FRAMES)
    file.write_text(scene.replace(f"laps: {loops.LAPS}", f"laps: {LAPS}"))
    return capture if seeded.call(args, f"{seed:03d}", "synth", file, "-o", capture) else None


def figures(args, seed):
    """ATE (m) and frames that were placed, by --poses; None where something failed (its log says what)."""
    name = f"{seed:03d}"
    result = args.work / "results" / f"{name}.json"
    known = json.loads(result.read_text()) if result.exists() else {}
    if all(poses in known for poses in args.poses):
        return known
    capture = rendered(args, seed)
    if capture is None:
        return None
    shown, hidden = recorded_copy(seed, capture, args.work / "captures" / f"{name}.recorded")
    row = {**known, "seed": seed, "frames": FRAMES, "hidden": hidden}
    for poses in args.poses:
        workspace = args.work / "workspaces" / f"{name}.{poses}"
        error = args.work / "results" / f"{name}.{poses}.ate.json"
        if not seeded.call(args, name, "run", shown, "-o", workspace, "--until", "track", "--poses", poses, "--progress", "none",
                           "--threads", args.threads, *args.run_options):
            return None
        if not seeded.call(args, name, "eval", "trajectory", workspace / "track/trajectory.tum", capture / "groundtruth.txt",
                           "--json", error):
            return None
        frames = json.loads((workspace / "track/frames.json").read_text())["frames"]
        row[poses] = {"ate_m": json.loads(error.read_text())["ate_m"]["rmse"],
                      "placed": sum(frame["status"] not in ("lost", "unreadable") for frame in frames)}
    result.write_text(json.dumps(row, indent=1) + "\n")
    return row


def table(rows, all_poses):
    lines = ["| room | frames, of which hidden | " + " | ".join(f"{poses}: ATE, placed" for poses in all_poses) + " |",
             "|---|---|" + "---|" * len(all_poses)]
    for row in rows:
        cells = [f"{100 * row[poses]['ate_m']:.2f} cm, {row[poses]['placed']}" for poses in all_poses]
        lines.append(f"| {row['seed']:03d} | {row['frames']}, {row['hidden']} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    args = seeded.arguments(__doc__, "out/recorded", "0-4", "poses", POSES)
    rows, failed = seeded.collect(args, lambda seed: figures(args, seed), [(seed,) for seed in args.seeds])
    if rows:
        print(table(rows, args.poses))
    worse = [row["seed"] for row in rows if "prior" in row and any(
        row["prior"]["ate_m"] > row[poses]["ate_m"] for poses in ("track", "capture") if poses in row)]
    if worse:
        print(f"--poses prior is not the best in rooms {', '.join(map(str, worse))}", file=sys.stderr)
    return 1 if failed or worse else 0


if __name__ == "__main__":
    sys.exit(main())
