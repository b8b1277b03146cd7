#!/usr/bin/env python3
"""Kills `deepslam run` inside every stage and checks that a second run ends in the bytes of an undisturbed one; also
that one and two threads give equal bytes.

    kill_test.py DEEPSLAM [--capture DIR] [--scene YAML] [--frames N] [-- more arguments of `deepslam run`]

Without --capture every fifth frame of redkitchen in $DEEPSLAM_TEST_DATA is used, else the demo scene of the repository
(--scene) is rendered. Exit 77: nothing to test with.
"""
import argparse
import hashlib
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

STAGES = ["track", "ground", "layout", "detect", "segment", "associate", "propose", "register", "select", "loops", "optimize",
          "mesh", "fuse", "export", "report"]
NOT_COMPARED = {"timing.json", "timing.html", ".lock"}  # times, and the process that held the workspace


def find_capture(frames, folder):
    data = os.environ.get("DEEPSLAM_TEST_DATA")
    source = pathlib.Path(data or "/nonexistent") / "data" / "redkitchen"
    if not source.is_dir():
        return None
    folder.mkdir()
    for name in ("rgb", "depth", "capture.yaml", "groundtruth.txt"):
        (folder / name).symlink_to(source / name)
    lines = (source / "associations.txt").read_text().splitlines()
    # Every fifth frame: enough motion for several keyframes.
    (folder / "associations.txt").write_text("\n".join(lines[:5 * frames:5]) + "\n")
    return folder


def render_capture(program, scene, frames, folder):
    short = folder.with_suffix(".yaml")
    short.write_text(re.sub(r"(?m)^frames: .*$", f"frames: {frames}", scene.read_text()))
    result = subprocess.run([program, "synth", str(short), "-o", str(folder)], capture_output=True, text=True)
    return folder if result.returncode == 0 else None


def command(program, capture, workspace, threads, more):
    return [program, "run", str(capture), "-o", str(workspace), "--threads", str(threads), "--progress", "none",
            "--log-level", "warning", *more]


def run_to_end(*arguments):
    result = subprocess.run(command(*arguments), capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"run failed with {result.returncode}:\n{result.stderr}")


def digests(workspace):
    found = {}
    for path in sorted(workspace.rglob("*")):
        if path.is_file() and path.name not in NOT_COMPARED:
            found[str(path.relative_to(workspace))] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def bytes_below(folder):
    """Of a folder that may be renamed meanwhile."""
    total = 0
    for place, _, files in os.walk(folder):
        for file in files:
            try:
                total += os.stat(os.path.join(place, file)).st_size
            except OSError:
                pass
    return total


def kill_inside(stage, workspace, arguments, delay_s, with_bytes=False):
    """Starts a run and kills it once the stage's partial folder lies there (with_bytes: once a file in it has bytes);
    what was seen, or None if it was too fast."""
    process = subprocess.Popen(command(*arguments), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    partial = workspace / f"{stage}.partial-{process.pid}"
    try:
        while process.poll() is None:
            if partial.exists() and (not with_bytes or bytes_below(partial) > 0):
                time.sleep(delay_s)
                process.send_signal(signal.SIGKILL)
                process.wait()
                return {"left": partial.exists(), "bytes": bytes_below(partial), "done": (workspace / stage).exists()}
            if with_bytes and (workspace / stage / "manifest.json").exists():
                return None  # over already
            time.sleep(0.0005 if not with_bytes else 0.0001)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    return None


def interrupt(workspace, arguments):
    """SIGINT ends a run with 130 and without a partial folder."""
    (workspace / "propose" / "manifest.json").unlink(missing_ok=True)
    process = subprocess.Popen(command(*arguments), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and not (workspace / f"propose.partial-{process.pid}").exists():
        time.sleep(0.0005)
    process.send_signal(signal.SIGINT)
    code = process.wait()
    partials = [p.name for p in workspace.iterdir() if ".partial-" in p.name]
    print(f"SIGINT    exit {code}, partial folders: {partials or 'none'}")
    return code == 130 and not partials


def compare(expected, found, what):
    differing = sorted(name for name in expected.keys() | found.keys() if expected.get(name) != found.get(name))
    if differing:
        print(f"FAILED {what}: differing files: {', '.join(differing[:10])}")
    return not differing


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--capture", type=pathlib.Path)
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--scene", type=pathlib.Path)
    parser.add_argument("more", nargs="*")
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    with tempfile.TemporaryDirectory(prefix="deepslam-kill-") as temp:
        temp = pathlib.Path(temp)
        capture = options.capture or find_capture(options.frames, temp / "capture")
        if capture is None and options.scene:
            capture = render_capture(program, options.scene, options.frames, temp / "rendered")
        if capture is None:
            print("skipped: no capture; set DEEPSLAM_TEST_DATA or pass --capture")
            return 77
        run_to_end(program, capture, temp / "one", 1, options.more)
        expected = digests(temp / "one")
        run_to_end(program, capture, temp / "two", 2, options.more)
        ok = compare(expected, digests(temp / "two"), "--threads 1 against 2")
        print(f"threads   1 and 2: {len(expected)} files, {'equal' if ok else 'NOT equal'}")

        workspace = temp / "killed"
        arguments = (program, capture, workspace, 2, options.more)
        hits = 0
        for stage in STAGES:
            # A stage shorter than the delay is tried again with less; every stage has to be hit inside.
            seen = None
            for delay_s in (0.15, 0.03, 0.005, 0.0):
                seen = kill_inside(stage, workspace, arguments, delay_s)
                if seen and seen["left"]:
                    break
                if (workspace / stage).exists():
                    (workspace / stage / "manifest.json").unlink()  # so that the stage runs again
            hit = bool(seen and seen["left"])
            hits += hit
            written = kill_inside(stage, workspace, arguments, 0.0, with_bytes=True) if hit else None
            print(f"{stage:<9} {'killed inside' if hit else 'NOT HIT'}, partial there: {bool(seen and seen['left'])}, "
                  f"bytes written: {seen['bytes'] if seen else 0}; again while writing: "
                  f"{str(written['bytes']) + ' bytes' if written and written['left'] else 'not hit'}")
        ok = interrupt(workspace, arguments) and ok
        run_to_end(*arguments)
        ok = compare(expected, digests(workspace), "after kills") and ok
        leftovers = [p.name for p in workspace.iterdir() if ".partial-" in p.name or ".old-" in p.name]
        print(f"{hits} of {len(STAGES)} stages hit; left over: {leftovers or 'nothing'}; "
              f"{'equal to the undisturbed run' if ok else 'NOT equal'}")
        return 0 if ok and hits == len(STAGES) and not leftovers else 1


if __name__ == "__main__":
    sys.exit(main())
