#!/usr/bin/env python3
"""How often objects of a map stand where it says, beside how sure the map is of them.

    scripts/experiments/calibration.py WORKSPACE CAPTURE [WORKSPACE CAPTURE]... [--deepslam PROGRAM]

Of every object of the maps, all as one set: `confidence`, and whether it stands within 20 cm, 20 deg and 20 % of size
of a true one of its class (`deepslam eval objects`). An object that is none of the true ones is wrong. Prints the
share that is right among those said to be about as sure, the log loss of what was said, and that of saying the mean
of all. Workspaces need stage `mesh`, captures their truth. Needs nothing beyond Python 3.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOUNDS = (0.0, 0.3, 0.6, 0.8, 0.9, 1.0)
SUREST = 0.999  # nothing is taken for surer: one wrong object would weigh more than all others


def placed(program, workspace, capture):
    """Names of the mapped objects that stand where a true one does."""
    done = subprocess.run([program, "eval", "objects", str(workspace), str(capture)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        sys.exit(f"deepslam eval objects {workspace} {capture} failed with exit {done.returncode}:\n{done.stderr}")
    return {row["mapped"] for row in json.loads(done.stdout)["objects"] if row.get("mapped") and row["placed"]}


def scored(program, workspace, capture):
    """(confidence, whether it is right) of every object of the map."""
    right = placed(program, workspace, capture)
    objects = json.loads((workspace / "loops/objects.json").read_text())["objects"]
    return [(one["confidence"], f"{one['class']}_{one['id']:02d}" in right) for one in objects]


def log_loss(pairs):
    kept = [(min(max(said, 1 - SUREST), SUREST), right) for said, right in pairs]
    return -sum(math.log(said if right else 1 - said) for said, right in kept) / len(kept)


def table(pairs):
    lines = ["| said | objects | said on average | right |", "|---|---|---|---|"]
    for low, high in zip(BOUNDS, BOUNDS[1:]):
        part = [pair for pair in pairs if low <= pair[0] < high or high == BOUNDS[-1] == pair[0]]
        means = [f"{sum(column) / len(part):.2f}" for column in zip(*part)] or ["", ""]
        lines.append(f"| {low} to {high} | {len(part)} | " + " | ".join(means) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="+", type=pathlib.Path, metavar="WORKSPACE CAPTURE")
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    args = parser.parse_args()
    if len(args.pairs) % 2:
        parser.error("a workspace without its capture; give them in pairs")
    pairs = [pair for workspace, capture in zip(args.pairs[::2], args.pairs[1::2])
             for pair in scored(args.deepslam.absolute(), workspace, capture)]
    if not pairs:
        sys.exit("the maps hold no object")
    num_right = sum(right for _, right in pairs)
    of_mean = log_loss([(num_right / len(pairs), right) for _, right in pairs])
    print(f"{table(pairs)}\n")
    print(f"{len(pairs)} objects, {num_right} right; log loss {log_loss(pairs):.3f}, of the mean {of_mean:.3f}")


if __name__ == "__main__":
    main()
