#!/usr/bin/env python3
"""Whole runs of a capture, held against what no run can do without.

    whole_run.py DEEPSLAM CAPTURE [--runs 3] [--threads 2] [--floor FLOOR.json] [--before OLD.json] [--json FILE] [--page FILE]
                 [-- more arguments of `deepslam run`]

Runs the whole chain so many times, each in an empty workspace. Medians of wall and processor time and the largest peak of
memory, per stage and of the process, go to --json; a page of tables in Markdown goes to --page (standard output without it).
--floor   results of deepslam_floor_bench (--benchmark_out) of the same capture: adds to each stage the time that decoding, forward
          passes or copying of the frames it looks at takes at least, and the ratio of the whole
--before  an older result of this script: adds its columns
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

STAGES = ("track", "ground", "layout", "detect", "segment", "associate", "propose", "register", "select", "loops", "optimize", "mesh",
          "fuse", "export", "report")


def one_run(program, capture, workspace, threads, more):
    command = [program, "run", capture, "-o", workspace, "--threads", threads, "--progress", "none", "--log-level", "warning", *more]
    begin = time.monotonic()
    child = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    with child.stderr:
        message = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        sys.exit(f"the run ended with {child.returncode}:\n{message}")
    stages = {stage: json.loads((workspace / stage / "timing.json").read_text()) for stage in STAGES}
    # Every stage starts its peak anew, and with it what the system tells of the process in the end.
    peak_mib = max(usage.ru_maxrss / 1024, *(figures["peak_memory_mib"] for figures in stages.values()))
    return {"wall_s": time.monotonic() - begin, "cpu_s": usage.ru_utime + usage.ru_stime, "peak_memory_mib": peak_mib,
            "load": os.getloadavg()[0], "stages": stages}


def figures(workspace, stage):
    return json.loads((workspace / stage / "manifest.json").read_text())["figures"]


def recorded_s(workspace):
    """From the first frame to the last, and one frame more."""
    times = [float(line.split()[0]) for line in (workspace / "track" / "trajectory.tum").read_text().splitlines()
             if line and not line.startswith("#")]
    return (times[-1] - times[0]) * len(times) / max(1, len(times) - 1)


def median_of(runs):
    def middle(values):
        return statistics.median(values)
    stages = {stage: {"wall_s": middle(run["stages"][stage]["wall_s"] for run in runs),
                      "cpu_s": middle(run["stages"][stage]["cpu_s"] for run in runs),
                      "peak_memory_mib": max(run["stages"][stage]["peak_memory_mib"] for run in runs)} for stage in STAGES}
    return {"wall_s": middle(run["wall_s"] for run in runs), "cpu_s": middle(run["cpu_s"] for run in runs),
            "peak_memory_mib": max(run["peak_memory_mib"] for run in runs), "load": middle(run["load"] for run in runs),
            "stages": stages}


def seconds_per_frame(floor_file):
    """name -> wall seconds per frame: median where there are repetitions."""
    seconds = {}
    for row in json.loads(floor_file.read_text())["benchmarks"]:
        if row.get("run_type") == "aggregate" and row.get("aggregate_name") != "median":
            continue
        name = row["name"].split("/")[0]
        if row.get("error_occurred"):
            sys.exit(f"{floor_file}: {name}: {row['error_message']}")
        seconds[name] = 1.0 / row["items_per_second"]
    return seconds


def floors(workspace, per_frame):
    """stage -> (what it cannot do without, seconds)."""
    frames = int(figures(workspace, "track")["num_frames"])
    keyframes = int(figures(workspace, "track")["num_keyframes"])
    looked_at = int(figures(workspace, "detect")["num_frames"])
    fused = int(figures(workspace, "fuse")["num_frames"])
    found = {"track": (f"decode {frames} frames", frames * per_frame["DecodeFrames"]),
             "detect": (f"{looked_at} forward passes", looked_at * per_frame["DetectorPasses"]),
             "fuse": (f"copy {fused} frames", fused * per_frame["CopyFrames"])}
    for stage, count in (("ground", keyframes), ("segment", looked_at), ("associate", looked_at), ("propose", looked_at),
                         ("register", looked_at), ("select", looked_at), ("loops", keyframes), ("mesh", looked_at)):
        found[stage] = (f"copy {count} frames", count * per_frame["CopyFrames"])
    return found


def table(result):
    before = result.get("before")
    head = ["stage", "wall s", "processor s", "peak MiB"]
    if before:
        head += ["wall s before", "processor s before", "peak MiB before"]
    if "floors" in result:
        head += ["floor s", "what the floor is"]
    rows = [head, ["---"] * len(head)]

    def cells(figures_of):
        return [f"{figures_of['wall_s']:.2f}", f"{figures_of['cpu_s']:.2f}", f"{figures_of['peak_memory_mib']:.0f}"]
    for stage in STAGES:
        row = [f"`{stage}`", *cells(result["stages"][stage])]
        if before:
            row += cells(before["stages"][stage])
        if "floors" in result:
            what, least = result["floors"].get(stage, ("", None))
            row += ["" if least is None else f"{least:.2f}", what]
        rows.append(row)
    last = ["whole run", *cells(result)] + (cells(before) if before else [])
    if "floors" in result:
        last += [f"{result['floor_s']:.2f}", "decoding once, and forward passes"]
    rows.append(last)
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def page(result):
    lines = [f"# Whole run of {result['capture']}", "",
             f"{result['frames']} frames recorded in {result['recorded_s']:.1f} s; {result['num_runs']} runs with {result['threads']} "
             f"threads, medians, peaks of memory at their largest; load of the machine {result['load']:.1f}.", "", table(result), ""]
    lines.append(f"Wall time over recorded time: {result['wall_s'] / result['recorded_s']:.2f}.")
    if "floors" in result:
        lines += [f"Wall time over decoding and forward passes: {result['wall_s'] / result['floor_s']:.2f}.",
                  "Wall time over decoding and forward passes of the detector as its file has it, a square with padding "
                  f"({result['padded_floor_s']:.2f} s): {result['wall_s'] / result['padded_floor_s']:.2f}."]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("capture", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--floor", type=pathlib.Path)
    parser.add_argument("--before", type=pathlib.Path)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--page", type=pathlib.Path)
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    given = parser.parse_args(sys.argv[1:split])
    runs = []
    with tempfile.TemporaryDirectory(prefix="deepslam-whole-run-") as temp:
        for number in range(given.runs):
            workspace = pathlib.Path(temp) / str(number)
            runs.append(one_run(given.program.resolve(), given.capture.resolve(), workspace, given.threads, sys.argv[split + 1:]))
            print(f"run {number}: {runs[-1]['wall_s']:.1f} s wall, {runs[-1]['cpu_s']:.1f} s of processors, "
                  f"{runs[-1]['peak_memory_mib']:.0f} MiB, load {runs[-1]['load']:.1f}", file=sys.stderr)
        result = {"capture": given.capture.resolve().name, "num_runs": given.runs, "threads": given.threads,
                  "frames": int(figures(workspace, "track")["num_frames"]), "recorded_s": recorded_s(workspace), **median_of(runs)}
        if given.floor:
            per_frame = seconds_per_frame(given.floor)
            result["floors"] = floors(workspace, per_frame)
            result["floor_s"] = result["floors"]["track"][1] + result["floors"]["detect"][1]
            result["padded_floor_s"] = (result["floors"]["track"][1] + result["floors"]["detect"][1] *
                                        per_frame["PaddedPasses"] / per_frame["DetectorPasses"])
    result["runs"] = [{key: value for key, value in run.items() if key != "stages"} for run in runs]
    if given.before:
        before = json.loads(given.before.read_text())
        result["before"] = before.get("whole_run", before)
    if given.json:
        given.json.write_text(json.dumps(result, indent=1) + "\n")
    if given.page:
        given.page.write_text(page(result))
    else:
        print(page(result))


if __name__ == "__main__":
    main()
