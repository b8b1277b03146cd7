#!/usr/bin/env python3
"""The project's experiments on rendered captures, with one command:

    scripts/experiments/run.py [--work out/experiments] [--scene F]... [--rung NAME]... [--quick] [-- RUN OPTIONS]

Renders the scenes (all of configs/scenes unless --scene names some), reconstructs them, scores the results and writes
docs/evaluation/results.md and docs/evaluation/*.svg, each with the command that made it. What exists in --work and still
holds is used again: an interrupted run goes on where it was. Every rung of a scene is a capture of its own. Each capture
is reconstructed with proposals from colour and depth and from colour alone; long_loop with and without loop closure, and
with tracking that drifts. Longer captures but that one are thinned to --max-frames over the same path, so that all takes less than an
hour on two cores; --quick takes at most 60 frames and halves images whose camera is written out. What follows `--` goes
to every `deepslam run`. Needs nothing beyond Python 3.
"""
import argparse
import os
import pathlib
import sys

from cases import ROOT, Case, make, rungs_of
from tables import write_results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/experiments")
    parser.add_argument("--docs", type=pathlib.Path, default=ROOT / "docs/evaluation", help="where tables and plots go")
    parser.add_argument("--scene", type=pathlib.Path, action="append", help="a scene file; may be repeated")
    parser.add_argument("--rung", action="append", help="of scenes with rungs only this one; may be repeated")
    parser.add_argument("--max-frames", type=int, default=240, help="of a capture (default: 240)")
    parser.add_argument("--quick", action="store_true", help="half the image size, at most 60 frames")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("run_options", nargs="*", metavar="RUN OPTION", help="for `deepslam run`, after --")
    args = parser.parse_args()
    args.deepslam = args.deepslam.absolute()
    args.work = args.work.absolute()
    if not os.access(args.deepslam, os.X_OK):
        sys.exit(f"{args.deepslam}: no such program; build it (scripts/build.sh) or name it with --deepslam")
    scenes = [scene.absolute() for scene in args.scene or []] or sorted((ROOT / "configs" / "scenes").glob("*.yaml"))
    for scene in scenes:
        if not scene.is_file():
            sys.exit(f"{scene}: no such scene file")
    args.work.mkdir(parents=True, exist_ok=True)
    cases = [Case(scene, rung, args.work) for scene in scenes for rung in rungs_of(scene.read_text())
             if not args.rung or rung in args.rung]
    if not cases:
        sys.exit(f"no scene has a rung named {', '.join(args.rung)}")
    made = [case for case in cases if make(case, args)]
    command = "scripts/experiments/run.py" + "".join(
        f" --scene {scene}" for scene in args.scene or []) + "".join(
        f" --rung {rung}" for rung in args.rung or []) + (" --quick" if args.quick else "") + (
        f" --max-frames {args.max_frames}" if args.max_frames != parser.get_default("max_frames") else "") + (
        " -- " + " ".join(args.run_options) if args.run_options else "")
    write_results(cases, args, command)
    return 0 if len(made) == len(cases) else 1


if __name__ == "__main__":
    sys.exit(main())
