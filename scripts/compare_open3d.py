#!/usr/bin/env python3
"""Tracking beside Open3D's hybrid RGB-D odometry, on the same frames with as many threads:

    python3 -m venv V && V/bin/pip install open3d==0.20.0
    V/bin/python scripts/compare_open3d.py CAPTURE... [--repeat 5] [--threads 2] [--frames N] [--deepslam build/release/tools/deepslam]

CAPTURE is a folder in the TUM layout with associations.txt, capture.yaml and groundtruth.txt (`deepslam convert` makes one).
Per capture: ATE of both, wall and processor time of both from opening the capture to the last pose, decoding included
(medians of --repeat, in turn), and the ratio of wall times. Open3D aligns each frame to the one before it, as its
reconstruction system does within a fragment, from no motion, with its default options but for the largest depth, which
is set to deepslam's. deepslam runs `deepslam run --until track` into a fresh workspace, so starting, hashing of the
capture and writing count against it. Frames that Open3D cannot align keep the pose before and are counted.
"""
import argparse
import json
import os
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
MAX_DEPTH_M = 8.0


def read_capture(folder):
    """Intrinsics, depth units per metre, and (time, colour, depth) of the frames."""
    text = (folder / "capture.yaml").read_text()
    number = {key: float(value) for key, value in re.findall(r"\b(width|height|fx|fy|cx|cy|depth_units_per_m):\s*([0-9.]+)", text)}
    frames = []
    for line in (folder / "associations.txt").read_text().splitlines():
        words = line.split()
        if len(words) == 4 and not line.startswith("#"):
            frames.append((float(words[0]), folder / words[1], folder / words[3]))
    if len(number) != 7 or not frames:
        sys.exit(f"{folder}: no capture of the TUM layout with capture.yaml and associations.txt; "
                 f"`deepslam convert {folder} OUT --to tum` makes one")
    return number, frames


def track_with_open3d(folder, num_frames, out):
    """Runs in a process of its own: times are the process's. Writes `out` as TUM poses, prints JSON."""
    import numpy as np
    import open3d as o3d
    begin_wall, begin = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF)
    number, frames = read_capture(folder)
    frames = frames[:num_frames]
    camera = o3d.camera.PinholeCameraIntrinsic(int(number["width"]), int(number["height"]), number["fx"], number["fy"],
                                               number["cx"], number["cy"])
    options = o3d.pipelines.odometry.OdometryOption(depth_max=MAX_DEPTH_M)
    hybrid = o3d.pipelines.odometry.RGBDOdometryJacobianFromHybridTerm()

    def read(frame):
        return o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.io.read_image(str(frame[1])), o3d.io.read_image(str(frame[2])),
            depth_scale=number["depth_units_per_m"], depth_trunc=MAX_DEPTH_M, convert_rgb_to_intensity=True)

    world_from_camera, poses, failed, before = np.eye(4), [np.eye(4)], 0, read(frames[0])
    for frame in frames[1:]:
        now = read(frame)
        ok, before_from_now, _ = o3d.pipelines.odometry.compute_rgbd_odometry(now, before, camera, np.eye(4), hybrid, options)
        failed += not ok
        world_from_camera = world_from_camera @ (before_from_now if ok else np.eye(4))
        poses.append(world_from_camera)
        before = now
    used = resource.getrusage(resource.RUSAGE_SELF)
    seconds = {"wall_s": time.monotonic() - begin_wall,
               "cpu_s": used.ru_utime + used.ru_stime - begin.ru_utime - begin.ru_stime}
    with open(out, "w") as file:
        for (stamp, _, _), pose in zip(frames, poses):
            x, y, z, w = quaternion(np, pose[:3, :3])
            file.write(f"{stamp:.6f} {pose[0, 3]:.9f} {pose[1, 3]:.9f} {pose[2, 3]:.9f} {x:.9f} {y:.9f} {z:.9f} {w:.9f}\n")
    print(json.dumps({**seconds, "failed": failed, "version": o3d.__version__}))


def quaternion(np, rotation):
    # The eigenvector of Shepperd's symmetric matrix: right for every rotation.
    r = rotation
    k = np.array([[r[0, 0] - r[1, 1] - r[2, 2], 0, 0, 0], [r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], 0, 0],
                  [r[2, 0] + r[0, 2], r[2, 1] + r[1, 2], r[2, 2] - r[0, 0] - r[1, 1], 0],
                  [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)]]) / 3
    return np.linalg.eigh(k)[1][:, -1]


def run_open3d(args, folder, out):
    command = [sys.executable, __file__, "--worker", str(out), "--frames", str(args.frames), str(folder)]
    done = subprocess.run(command, env={**os.environ, "OMP_NUM_THREADS": str(args.threads)}, stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def run_deepslam(args, folder, workspace):
    command = [str(args.deepslam), "run", str(folder), "-o", str(workspace), "--until", "track", "--threads", str(args.threads),
               "--progress", "none"]
    begin_wall, begin = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {"wall_s": time.monotonic() - begin_wall,
            "cpu_s": used.ru_utime + used.ru_stime - begin.ru_utime - begin.ru_stime}


def ate_cm(args, estimate, folder, scratch):
    file = scratch / "ate.json"
    command = [str(args.deepslam), "eval", "trajectory", str(estimate), str(folder / "groundtruth.txt"), "--json", str(file)]
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    return 100 * json.loads(file.read_text())["ate_m"]["rmse"]


def first_frames(folder, count, scratch):
    """The capture's first frames as a capture of their own, so that both programs see the same."""
    small = scratch / "capture"
    small.mkdir()
    for name in ("capture.yaml", "groundtruth.txt"):
        (small / name).write_text((folder / name).read_text())
    _, frames = read_capture(folder)
    lines = []
    for stamp, colour, depth in frames[:count]:
        lines.append(f"{stamp:.6f} {colour.relative_to(folder)} {stamp:.6f} {depth.relative_to(folder)}\n")
    (small / "associations.txt").write_text("".join(lines))
    for name in {path.relative_to(folder).parts[0] for frame in frames for path in frame[1:]}:
        (small / name).symlink_to((folder / name).absolute(), target_is_directory=True)
    return small


def compare(args, folder, scratch):
    name = folder.name
    if args.frames:
        folder = first_frames(folder, args.frames, scratch)
    theirs, ours = [], []
    for n in range(args.repeat):
        theirs.append(run_open3d(args, folder, scratch / "open3d.tum"))
        ours.append(run_deepslam(args, folder, scratch / f"workspace{n}"))
    row = {"capture": name, "frames": len(read_capture(folder)[1]), "open3d": theirs[0]["version"],
           "open3d_failed": theirs[0]["failed"],
           "open3d_ate_cm": ate_cm(args, scratch / "open3d.tum", folder, scratch),
           "ate_cm": ate_cm(args, scratch / "workspace0/track/trajectory.tum", folder, scratch)}
    for prefix, runs in (("open3d_", theirs), ("", ours)):
        for key in ("wall_s", "cpu_s"):
            row[prefix + key] = statistics.median(run[key] for run in runs)
    row["times_faster"] = row["open3d_wall_s"] / row["wall_s"]
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("captures", type=pathlib.Path, nargs="+", metavar="CAPTURE")
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--frames", type=int, default=0, help="the first N alone (default: all)")
    parser.add_argument("--worker", type=pathlib.Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.worker:
        return track_with_open3d(args.captures[0], args.frames or None, args.worker)
    if not os.access(args.deepslam, os.X_OK):
        sys.exit(f"{args.deepslam}: no such program; build it (scripts/build.sh) or name it with --deepslam")
    print("| capture | frames | ATE Open3D (not aligned) | deepslam | wall, processor s Open3D | deepslam | times faster |")
    print("|" + "---|" * 7, flush=True)
    for folder in args.captures:
        with tempfile.TemporaryDirectory() as scratch:
            row = compare(args, folder, pathlib.Path(scratch))
        print(f"| {folder.name} | {row['frames']} | {row['open3d_ate_cm']:.2f} cm ({row['open3d_failed']}) | {row['ate_cm']:.2f} cm "
              f"| {row['open3d_wall_s']:.1f}, {row['open3d_cpu_s']:.1f} | {row['wall_s']:.2f}, {row['cpu_s']:.2f} "
              f"| {row['times_faster']:.1f} |", flush=True)
        print(json.dumps(row), file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
