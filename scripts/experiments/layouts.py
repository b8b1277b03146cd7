#!/usr/bin/env python3
"""Homes with truth as a benchmark of rooms, walls, doors and windows.

    layouts.py [--seeds 21-24] [--captures DIR] [--work DIR] [-- RUN OPTION...]

Each home is rendered once (`deepslam synth --home SEED`, Kinect noise, furniture before its walls, a walk through every door), run up
to stage `layout`, and held against its truth by `deepslam eval layout`. What is there already is used again: captures always,
workspaces where their keys still fit, so that a changed option costs stage `layout` alone. Printed: a table with a row per home and
one for all, as counts: walls that were found of those seen, walls told that are right of those told, rooms, the median corner and area,
and by kind of opening those found of true ones and of those told, with F1 over all. Exit code 1: a home failed. Plain Python.
"""
import argparse
import json
import os
import pathlib
import sys

import seeded
from seeded import ROOT

KINDS = ("door", "window", "passage")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/layouts")
    parser.add_argument("--captures", type=pathlib.Path, help="where homes lie, by seed (default: WORK/captures)")
    parser.add_argument("--seeds", type=seeded.seeds_of, default="21-24", metavar="LIST", help="as 2,21-24 (default: 21-24)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("run_options", nargs="*", metavar="RUN OPTION", help="for `deepslam run`, after --")
    args = parser.parse_args()
    args.deepslam, args.work = args.deepslam.absolute(), args.work.absolute()
    args.captures = args.captures or args.work / "captures"
    if not os.access(args.deepslam, os.X_OK):
        sys.exit(f"{args.deepslam}: no such program; build it (scripts/build.sh) or name it with --deepslam")
    for folder in ("workspaces", "results", "logs"):
        (args.work / folder).mkdir(parents=True, exist_ok=True)
    return args


def figures(args, seed):
    """What `eval layout` says of one home; None where something failed (its log says what)."""
    capture, workspace = args.captures / str(seed), args.work / "workspaces" / str(seed)
    if not (capture / "groundtruth.txt").exists() and not seeded.call(args, seed, "synth", "--home", seed, "-o", capture):
        return None
    if not seeded.call(args, seed, "run", capture, "-o", workspace, "--until", "layout", "--progress", "none",
                       "--threads", args.threads, *args.run_options):
        return None
    result = args.work / "results" / f"{seed}.json"
    if not seeded.call(args, seed, "eval", "layout", workspace, capture, "--json", result):
        return None
    score = json.loads(result.read_text(encoding="utf-8"))["pairs"][0]
    of_kind = {row["kind"]: row for row in score["openings"]}
    return {
        "seed": seed,
        "walls": score["num_true_walls"], "walls_found": score["num_true_walls"] - len(score["missed_walls"]),
        "told": score["num_walls"], "right": score["num_walls"] - len(score["wrong_walls"]),
        "rooms": score["num_true_rooms"], "rooms_found": score["num_found_rooms"],
        "corner_mm": 1000 * score["corner_median_m"], "area_percent": 100 * score["room_area_error_median"],
        **{f"{kind}_{what}": value for kind in KINDS for what, value in (
            ("true", of_kind[kind]["num_true"]), ("told", of_kind[kind]["num_estimated"]),
            ("found", round(of_kind[kind]["recall"] * of_kind[kind]["num_true"])))},
    }


def row(name, home):
    cells = [name, f"{home['walls_found']} of {home['walls']}", f"{home['right']} of {home['told']}",
             f"{home['rooms_found']} of {home['rooms']}", f"{home['corner_mm']:.0f} mm", f"{home['area_percent']:.1f} %"]
    for kind in KINDS:
        true, told, found = (home[f"{kind}_{what}"] for what in ("true", "told", "found"))
        share = f", F1 {2 * found / (true + told):.2f}" if true + told else ""
        cells.append(f"{found} of {true}, {told} told{share}")
    return f"| {' | '.join(cells)} |"


def table(homes):
    pooled = {key: sum(home[key] for home in homes) for key in homes[0] if key != "seed"}
    for key in ("corner_mm", "area_percent"):
        pooled[key] = sorted(home[key] for home in homes)[len(homes) // 2]
    return "\n".join(["| home | walls found | told that are right | rooms | corners | area | doors | windows | passages |",
                      "|---" * 9 + "|", *(row(str(home["seed"]), home) for home in homes), row("all", pooled)])


def main():
    args = arguments()
    homes, failed = seeded.collect(args, lambda seed: figures(args, seed), ((seed,) for seed in args.seeds))
    if homes:
        print(table(homes))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
