#!/usr/bin/env python3
"""Furnished homes with truth: how much of their furniture becomes an object of the map, per home and of all together.

    scripts/experiments/homes.py [--seeds 31-34,2] [--frames-per-s 5] [--work out/homes] [-- RUN OPTIONS]

Renders the homes that are not in --captures yet (`deepslam synth --home SEED`, at 10 frames a second unless --frames-per-s says
otherwise), maps each with the program's defaults and what
follows `--`, and scores it by `deepslam eval objects`. Prints, per home and pooled: recall at box IoU 0.25 and 0.5, recall with
the right class and precision at 0.25, mapped objects that hold several true ones and true ones that hold several mapped ones,
the share of all true objects that stand within 20 cm, 20 deg and 20 %, and the path's error (ATE), which bounds all of these
from above; `-- --poses capture` takes it out. Then what was taken for what, and what was missed. Needs nothing beyond Python 3.
"""
import argparse
import collections
import json
import pathlib
import subprocess
import sys
import time

import seeded

ROOT = pathlib.Path(__file__).resolve().parents[2]
MIN_IOU = 0.25  # of boxes of what counts as found


def call(args, log, *command):
    """Wall-clock seconds; ends the program where the command fails."""
    start = time.monotonic()
    with open(log, "ab") as out:
        done = subprocess.run([str(args.deepslam), *map(str, command)], stdout=out, stderr=out, check=False)
    if done.returncode:
        sys.exit(f"deepslam {command[0]} failed with exit {done.returncode}; see {log}")
    return time.monotonic() - start


def scored(args, seed):
    """The figures of `deepslam eval objects` of one home, with the time of its run."""
    capture = args.captures / str(seed)
    workspace = args.work / str(seed)
    log = args.work / f"{seed}.log"
    if not (capture / "truth/objects.json").is_file():
        filming = ["--frames-per-s", args.frames_per_s] if args.frames_per_s else []
        for field in args.field:
            filming += ["--field", field]
        call(args, log, "synth", "--home", seed, "-o", capture, *filming)
    seconds = call(args, log, "run", capture, "-o", workspace, "--threads", args.threads, "--progress", "none",
                   *args.run_options)
    result = args.work / f"{seed}.json"
    call(args, log, "eval", "objects", workspace, capture, "--json", result)
    return json.loads(result.read_text()), seconds


def counts(figures):
    at_quarter, at_half = figures["boxes"]["scores"]
    return collections.Counter(true=at_quarter["num_true"], mapped=at_quarter["num_mapped"], found=at_quarter["num_found"],
                               half=at_half["num_found"], right=at_quarter["num_right_class"],
                               merged=figures["boxes"]["num_merged"], split=figures["boxes"]["num_split"],
                               placed=figures["summary"]["num_placed"])


def row(name, sums, ate_m, seconds):
    true, mapped = max(1, sums["true"]), max(1, sums["mapped"])
    return (f"{name:>6} {sums['true']:>5} {sums['mapped']:>7} {sums['found'] / true:>7.2f} {sums['half'] / true:>7.2f} "
            f"{sums['right'] / true:>7.2f} {sums['found'] / mapped:>10.2f} {sums['merged']:>7} {sums['split']:>6} "
            f"{sums['placed'] / true:>7.2f} {100 * ate_m:>7.1f} {seconds:>8.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/homes")
    parser.add_argument("--captures", type=pathlib.Path, help="where homes lie as SEED, or are rendered (default: WORK/captures)")
    parser.add_argument("--seeds", default="31-34", help="as 2,31-34 (default: 31-34)")
    parser.add_argument("--frames-per-s", type=float, help="of homes that are rendered (default: 10)")
    parser.add_argument("--field", action="append", default=[], metavar="NAME=VALUE",
                        help="of how rendered homes are filmed, as camera.preset=d435 or faults.noise_scale=2; may be given again")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("run_options", nargs="*", metavar="RUN OPTION", help="for `deepslam run`, after --")
    args = parser.parse_args()
    args.deepslam, args.work = args.deepslam.absolute(), args.work.absolute()
    args.captures = (args.captures or args.work / "captures").absolute()
    args.work.mkdir(parents=True, exist_ok=True)
    args.captures.mkdir(parents=True, exist_ok=True)
    print("  home  true  mapped  recall  at 0.5   right  precision  merged  split  placed  ATE cm  seconds")
    total, total_s, worst_m = collections.Counter(), 0.0, 0.0
    confusions, missed = collections.Counter(), collections.Counter()
    for seed in seeded.seeds_of(args.seeds):
        figures, seconds = scored(args, seed)
        sums = counts(figures)
        ate_m = figures["pairs"][0]["trajectory"]["ate_rmse_m"]
        print(row(str(seed), sums, ate_m, seconds), flush=True)
        worst_m = max(worst_m, ate_m)
        total.update(sums)
        total_s += seconds
        for one in figures["boxes"]["confusions"]:
            confusions[one["true_class"], one["mapped_class"]] += one["count"]
        for one in figures["classes"]:
            missed[one["class"]] += one["num_true"]
        missed.subtract(match["true_class"] for match in figures["boxes"]["matches"] if match["iou"] >= MIN_IOU)
    print(row("all", total, worst_m, total_s))
    print("taken for another:", ", ".join(f"{t} for {m} {n}" for (t, m), n in sorted(confusions.items()) if t != m) or "none")
    print("missed:", ", ".join(f"{name} {n}" for name, n in sorted(missed.items()) if n > 0) or "none")


if __name__ == "__main__":
    main()
