"""What drivers of seeded rooms have in common: their command line, their folders, and calls of the program with a log."""
import argparse
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("captures", "workspaces", "results", "logs", "scenes")


def arguments(description, work, seeds, option, choices, more=None):
    """Arguments with `seeds` as a range and args.<option> as a list of some of `choices`; the folders are made. `more` adds arguments."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / work)
    parser.add_argument("--seeds", default=seeds, help=f"such as 2,21-24 (default: {seeds})")
    parser.add_argument(f"--{option}", default=",".join(choices))
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("run_options", nargs="*", metavar="RUN OPTION", help="for `deepslam run`, after --")
    if more:
        more(parser)
    args = parser.parse_args()
    args.deepslam, args.work = args.deepslam.absolute(), args.work.absolute()
    if not os.access(args.deepslam, os.X_OK):
        sys.exit(f"{args.deepslam}: no such program; build it (scripts/build.sh) or name it with --deepslam")
    chosen = getattr(args, option).split(",")
    if unknown := set(chosen) - set(choices):
        sys.exit(f"--{option}: {', '.join(sorted(unknown))} unknown; known are {', '.join(choices)}")
    setattr(args, option, chosen)
    args.seeds, args.seeds_text = seeds_of(args.seeds), args.seeds
    for folder in FOLDERS:
        (args.work / folder).mkdir(parents=True, exist_ok=True)
    return args


def seeds_of(text):
    """`2,21-24` as numbers."""
    seeds = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        seeds += range(int(first), int(last or first) + 1)
    return seeds


def call(args, name, *command):
    """Whether `deepslam command` succeeded; what it said is appended to the log of that name."""
    log = args.work / "logs" / f"{name}.log"
    with open(log, "ab") as out:
        code = subprocess.run([str(args.deepslam), *map(str, command)], stdout=out, stderr=out, check=False).returncode
    if code != 0:
        print(f"{name}: {command[0]} failed with exit {code}; see {log}", file=sys.stderr)
    return code == 0


def collect(args, figures_of, cases):
    """The figures of every case that has some, each said as JSON on stderr, and the number of those that failed."""
    rows, failed = [], 0
    for case in cases:
        figures = figures_of(*case)
        if figures is None:
            failed += 1
            print(f"{' '.join(map(str, case))} failed; see {args.work / 'logs'}", file=sys.stderr)
            continue
        rows.append(figures)
        print(json.dumps(figures), file=sys.stderr, flush=True)
    return rows, failed
