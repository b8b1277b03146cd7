#!/usr/bin/env python3
"""Views of a real capture split in halves: what is selected on one half, scored by the depth of the other.

    scripts/experiments/halves.py CAPTURE [--deepslam PROGRAM] [--work out/halves] [-- RUN OPTIONS]

The detector runs once. Of the keyframes, which it looks at, the even ones are one half, the odd ones the other; each half's detections
make a map of their own (`detect.source=file`, no depth clusters, `associate.method=votes`), with the same tracking. `deepslam eval
selection --held-out --judge-by` then scores the models of each half in the views that the other half has of the same object: the
share of the object's depth within 2 cm of the model, and the share of the rays that go through it. Objects of both halves are one
set; they are told one by one, and their means for the first candidate, the fused shape, the best as proposed and the selected one.
Needs nothing beyond Python 3.
"""
import argparse
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HALVES = ("even", "odd")
ROWS = ("initial", "fused", "as proposed", "selected")
# All of them, as outlines are cut there; a sharper frame beside one would put the same view into both halves.
KEYFRAMES = ("--set", "detect.frames=keyframes")
# By votes: things found in the surface of all frames would be made of both halves.
FROM_FILE = ("--set", "detect.source=file", "--set", "detect.clusters.enabled=false", "--set", "associate.method=votes")


def halved(detections, first):
    """The COCO file with every other image of those that were looked at, and what was found there."""
    kept = {image["id"] for image in detections["images"][first::2]}
    return {**detections, "annotations": [one for one in detections["annotations"] if one["image_id"] in kept]}


def call(program, *command):
    done = subprocess.run([program, *map(str, command)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        sys.exit(f"deepslam {command[0]} failed with exit {done.returncode}:\n{done.stderr}")


def mapped_halves(args):
    """Half -> workspace."""
    whole = args.work / "whole"
    call(args.deepslam, "run", args.capture, "-o", whole, "--until", "detect", *KEYFRAMES, *args.run_options)
    detections = json.loads((whole / "detect/detections.json").read_text())
    workspaces = {}
    for first, half in enumerate(HALVES):
        file = args.work / f"{half}.json"
        file.write_text(json.dumps(halved(detections, first)))
        workspaces[half] = args.work / half
        call(args.deepslam, "run", args.capture, "-o", workspaces[half], "--until", "loops", *FROM_FILE,
             "--set", f"detect.file={file}", *args.run_options)
    return workspaces


def scored_objects(args, workspaces):
    """Rows of all objects that the other half has as well; and how many it has not."""
    found, missing = [], 0
    for half, other in zip(HALVES, reversed(HALVES)):
        result = args.work / f"{half}_by_{other}.json"
        call(args.deepslam, "eval", "selection", "--held-out", "--judge-by", workspaces[other], workspaces[half], args.capture,
             "--json", result)
        for row in json.loads(result.read_text())["objects"]:
            if row["num_frames"]:
                found.append({**row, "half": half})
            else:
                missing += 1
    return found, missing


def cells(entry):
    if not entry or "depth_near" not in entry:
        return ["", ""]
    through = entry["num_violated"] / entry["num_judged"] if entry["num_judged"] else 0.0
    return [f"{entry['depth_near']:.3f}", f"{through:.3f}"]


def mean(objects, row):
    """Over the objects that have such a candidate."""
    of_row = [cells(entry[row]) for entry in objects if row in entry]
    of_row = [tuple(map(float, pair)) for pair in of_row if pair[0]]
    return [f"{sum(values) / len(values):.3f}" for values in zip(*of_row)] + [str(len(of_row))] if of_row else ["", "", "0"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("capture", type=pathlib.Path)
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/halves")
    parser.add_argument("run_options", nargs="*", metavar="RUN OPTION", help="for `deepslam run`, after --")
    args = parser.parse_intermixed_args()
    args.deepslam, args.work, args.capture = args.deepslam.absolute(), args.work.absolute(), args.capture.absolute()
    args.work.mkdir(parents=True, exist_ok=True)
    objects, missing = scored_objects(args, mapped_halves(args))
    print("| object, half it was selected on | " + " | ".join(f"{row}: depth near, rays through" for row in ROWS) + " |")
    print("|---" * (len(ROWS) + 1) + "|")
    for entry in objects:
        print(f"| {entry['mapped']}, {entry['half']} | " + " | ".join(", ".join(cells(entry.get(row))) for row in ROWS) + " |")
    print("| mean (objects) | " + " | ".join("{}, {} ({})".format(*mean(objects, row)) for row in ROWS) + " |")
    if missing:
        print(f"\n{missing} objects that the other half does not have were not scored.")


if __name__ == "__main__":
    main()
