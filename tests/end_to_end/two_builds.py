#!/usr/bin/env python3
"""Runs of two builds (two compilers, two machines' settings) held against each other by what they mean: camera poses, ground,
objects, scores, within the tolerances at the head of golden_demo_test.py. Says too from which stage on the bytes differ.

    two_builds.py DEEPSLAM OTHER_DEEPSLAM CAPTURE_OR_SCENE... [-- more arguments of `deepslam run`]

A scene (YAML) is rendered once, by the first build. Exit 1: a difference beyond the tolerances.
"""
import argparse
import hashlib
import pathlib
import sys
import tempfile

import captures
import golden_demo_test

# Told apart by every run: when, and how long it took.
PASSING = ("manifest.json", "timing.json")


def run(program, capture, workspace, more):
    done = captures.deepslam(program, "run", capture, "-o", workspace, "--progress", "none", *more, data=None, timeout=3600)
    if done.returncode != 0:
        sys.exit(f"{program} ended with {done.returncode}: {done.stderr}")
    return workspace


def contents(folder):
    return {str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
            for file in sorted(folder.rglob("*")) if file.is_file() and file.name not in PASSING}


def stages_that_differ(a, b):
    """In the order in which they ran."""
    manifests = sorted(a.glob("*/manifest.json"), key=lambda file: file.stat().st_mtime_ns)
    order = [file.parent.name for file in manifests]
    return [stage for stage in order if contents(a / stage) != contents(b / stage)]


def render(program, scene, folder):
    done = captures.deepslam(program, "synth", scene, "-o", folder, data=None, timeout=3600)
    if done.returncode != 0:
        sys.exit(f"deepslam synth {scene} ended with {done.returncode}: {done.stderr}")
    return folder


def compare(programs, capture, more, folder):
    """The differences beyond the tolerances."""
    if capture.suffix in (".yaml", ".yml"):
        capture = render(programs[0], capture, folder / "capture")
    first, other = (run(program, capture, folder / name, more) for program, name in zip(programs, ("first", "other")))
    golden, found = golden_demo_test.summary_of(first), golden_demo_test.summary_of(other)
    said = list(golden_demo_test.faults(golden, found))
    differing = stages_that_differ(first, other)
    bytes_say = f"bytes differ in {', '.join(differing)}" if differing else "the same bytes in every stage"
    print(f"{len(golden['keyframes'])} keyframes, {len(golden['objects'])} objects: {len(said)} differences beyond the "
          f"tolerances; {bytes_say}", flush=True)
    return said


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("other", type=pathlib.Path)
    parser.add_argument("captures", type=pathlib.Path, nargs="+")
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    given = parser.parse_args(sys.argv[1:split])
    said = []
    for capture in given.captures:
        print(f"{capture}: ", end="", flush=True)
        with tempfile.TemporaryDirectory(prefix="deepslam-two-builds-") as temp:
            faults = compare((given.program.resolve(), given.other.resolve()), capture.resolve(), sys.argv[split + 1:],
                             pathlib.Path(temp))
        for fault in faults:
            print(f"  {fault}")
        said += faults
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main())
