#!/usr/bin/env python3
"""How time and memory of a whole run grow with the length of a capture.

    growth.py DEEPSLAM SCENE [--frames 1000 3000 10000] [--captures DIR] [--threads 2] [--json FILE] [--page FILE]
              [-- more arguments of `deepslam run`]

SCENE is a walk with `frames` and `laps` (configs/scenes/long_loop.yaml): each capture goes round as often as keeps the camera's
speed, so that longer ones differ in nothing but their length. Captures are rendered into DIR (a folder of the moment without
it) unless they are there. The page tells, for each length, seconds, seconds over those of the recording, milliseconds of
processor per frame and the peak of memory, of the whole and by stage, and the exponent from one length to the next: 1 is linear.
"""
import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import whole_run


def number(text, name):
    found = re.search(rf"^\s*{name}:\s*([0-9.]+)\s*(#.*)?$", text, re.MULTILINE)
    if not found:
        sys.exit(f"the scene has no line '{name}: NUMBER'; take a walk that goes round, such as configs/scenes/long_loop.yaml")
    return float(found[1])


def lengthened(scene, frames):
    """The scene's text with so many frames at the same speed."""
    text = scene.read_text()
    laps = number(text, "laps") * frames / number(text, "frames")
    text = re.sub(r"^(\s*frames:\s*)[0-9.]+", rf"\g<1>{frames}", text, count=1, flags=re.MULTILINE)
    return re.sub(r"^(\s*laps:\s*)[0-9.]+", rf"\g<1>{laps:.6f}", text, count=1, flags=re.MULTILINE)


def rendered(program, scene, frames, captures):
    capture = captures / f"{scene.stem}_{frames}"
    if (capture / "groundtruth.txt").exists():
        return capture
    file = captures / f"{capture.name}.yaml"
    file.write_text(lengthened(scene, frames))
    subprocess.run([program, "synth", file, "-o", capture], check=True, stdout=subprocess.DEVNULL)
    return capture


def exponent(before, after, frames_before, frames_after):
    return math.log(after / before) / math.log(frames_after / frames_before)


def table(rows):
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows)


def whole_table(results):
    rows = [["frames", "recorded s", "wall s", "of recorded", "processor ms a frame", "exponent", "peak MiB"], ["---"] * 7]
    for i, result in enumerate(results):
        last = results[i - 1] if i else None
        grows = f"{exponent(last['wall_s'], result['wall_s'], last['frames'], result['frames']):.2f}" if last else ""
        rows.append([result["frames"], f"{result['recorded_s']:.0f}", f"{result['wall_s']:.1f}",
                     f"{result['wall_s'] / result['recorded_s']:.2f}", f"{1000 * result['cpu_s'] / result['frames']:.1f}", grows,
                     f"{result['peak_memory_mib']:.0f}"])
    return table(rows)


def stage_table(results):
    rows = [["stage, processor ms a frame (peak MiB)", *(result["frames"] for result in results)], ["---"] * (len(results) + 1)]
    for stage in whole_run.STAGES:
        of_stage = [result["stages"][stage] for result in results]
        rows.append([f"`{stage}`", *(f"{1000 * figures['cpu_s'] / result['frames']:.2f} ({figures['peak_memory_mib']:.0f})"
                                     for figures, result in zip(of_stage, results))])
    return table(rows)


def measured(given, more, captures, workspaces):
    results = []
    for frames in given.frames:
        capture = rendered(given.program, given.scene, frames, captures)
        workspace = workspaces / str(frames)
        result = whole_run.one_run(given.program, capture, workspace, given.threads, more)
        results.append({**result, "frames": int(whole_run.figures(workspace, "track")["num_frames"]),
                        "recorded_s": whole_run.recorded_s(workspace)})
        print(f"{frames} frames: {result['wall_s']:.1f} s wall, {result['cpu_s']:.1f} s of processors, "
              f"{result['peak_memory_mib']:.0f} MiB, load {result['load']:.1f}", file=sys.stderr)
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--frames", type=int, nargs="+", default=[1000, 3000, 10000])
    parser.add_argument("--captures", type=pathlib.Path)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--page", type=pathlib.Path)
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    given = parser.parse_args(sys.argv[1:split])
    given.program = given.program.resolve()
    with tempfile.TemporaryDirectory(prefix="deepslam-growth-") as temp:
        captures = given.captures or pathlib.Path(temp) / "captures"
        captures.mkdir(parents=True, exist_ok=True)
        results = measured(given, sys.argv[split + 1:], captures, pathlib.Path(temp))
    page = f"# Growth of {given.scene.stem}\n\n{whole_table(results)}\n\n{stage_table(results)}\n"
    if given.json:
        given.json.write_text(json.dumps(results, indent=1) + "\n")
    if given.page:
        given.page.write_text(page)
    else:
        print(page)


if __name__ == "__main__":
    main()
