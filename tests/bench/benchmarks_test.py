#!/usr/bin/env python3
"""Every benchmark still runs: the smallest of each, once, and untimed.

    benchmarks_test.py DEEPSLAM PROGRAM...

PROGRAM are the benchmark programs. Those that take a capture get a rendered room of ten frames.
Exit 77: no furniture to render it with.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "end_to_end"))
import captures  # noqa: E402


def first_of_each(program, environment):
    """Names of a program's benchmarks, of those that differ by their arguments the first."""
    listed = subprocess.run([program, "--benchmark_list_tests"], check=True, capture_output=True, text=True, env=environment)
    first = {}
    for name in listed.stdout.split():
        first.setdefault(name.split("/")[0], name)
    return list(first.values())


def failure(program, name, folder, environment):
    """What is wrong with one of them, or nothing."""
    out = folder / "result.json"
    ran = subprocess.run([program, f"--benchmark_filter=^{name}$", "--benchmark_min_time=0.001", f"--benchmark_out={out}",
                          "--benchmark_out_format=json"], capture_output=True, text=True, timeout=600, env=environment)
    if ran.returncode != 0:
        return f"ended with {ran.returncode}: {ran.stderr[-500:]}"
    results = json.loads(out.read_text())["benchmarks"]
    if len(results) != 1:
        return f"{len(results)} results instead of one"
    if results[0].get("error_occurred"):
        return results[0]["error_message"]
    return "" if results[0]["real_time"] > 0 else "took no time"


def main():
    deepslam, *programs = sys.argv[1:]
    if not programs:
        sys.exit("no benchmark programs are named")
    with tempfile.TemporaryDirectory(prefix="deepslam-benchmarks-") as temp:
        folder = pathlib.Path(temp)
        capture = captures.make_room(deepslam, folder / "room")
        if capture is None:
            print("skipped: no furniture catalogues; install sweethome3d-furniture")
            return 77
        environment = dict(os.environ, DEEPSLAM_BENCH_CAPTURE=str(capture), DEEPSLAM_BENCH_FRAMES="6")
        failed = 0
        for program in programs:
            names = first_of_each(program, environment)
            failed += not names
            for name in names:
                wrong = failure(program, name, folder, environment)
                without_weights = wrong.startswith("detect.weights: no file")
                print(f"{pathlib.Path(program).name} {name}: {'skipped: ' if without_weights else ''}{wrong or 'ok'}", flush=True)
                failed += bool(wrong) and not without_weights
        return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
