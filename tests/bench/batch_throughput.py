#!/usr/bin/env python3
"""Throughput of `deepslam batch --jobs 2` against two single processes side by side, on the same captures.

    batch_throughput.py DEEPSLAM CAPTURE [--pieces 8] [--frames 60] [--step 1] [--rounds 3] [-- options of both]

The capture (TUM layout) is cut into pieces. "Two singles" are two queues that call `deepslam run` for one piece after another,
each with half of the cores. Rounds alternate; the medians and their ratio are printed as JSON. Wall time is what counts; CPU
time says whether another program disturbed it.
"""
import argparse
import json
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time


def cut(source, folder, first, count, step):
    folder.mkdir(parents=True)
    for entry in source.iterdir():
        if entry.name != "associations.txt":
            (folder / entry.name).symlink_to(entry.resolve())
    lines = [line for line in (source / "associations.txt").read_text().splitlines() if not line.startswith("#")]
    (folder / "associations.txt").write_text("\n".join(lines[first:first + count * step:step]) + "\n")
    return folder


def measured(work):
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    work()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {"wall_s": time.monotonic() - start,
            "cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}


def call(*arguments):
    result = subprocess.run([*map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if result.returncode != 0:
        sys.exit(f"{arguments[1]} failed with {result.returncode}:\n{result.stderr}")


def two_singles(program, pieces, out, threads, options):
    queue, lock = list(pieces), threading.Lock()

    def work():
        while True:
            with lock:
                if not queue:
                    return
                piece = queue.pop(0)
            call(program, "run", piece, "-o", out / piece.name, "--threads", threads // 2, "--progress", "none", *options)
    workers = [threading.Thread(target=work) for _ in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("capture", type=pathlib.Path)
    parser.add_argument("--pieces", type=int, default=8)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--step", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=3)
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    given = parser.parse_args(sys.argv[1:split])
    given.options = sys.argv[split + 1:]
    program, threads = given.program.resolve(), max(2, os.cpu_count() or 2)
    rows = {"batch": [], "singles": []}
    with tempfile.TemporaryDirectory(prefix="deepslam-throughput-") as temp:
        temp = pathlib.Path(temp)
        pieces = [cut(given.capture.resolve(), temp / f"piece_{i}", i * given.frames * given.step, given.frames, given.step)
                  for i in range(given.pieces)]
        for number in range(given.rounds):
            out = temp / f"round_{number}"
            out.mkdir()
            for what in (("batch", "singles") if number % 2 == 0 else ("singles", "batch")):
                if what == "batch":
                    row = measured(lambda: call(program, "batch", *pieces, "-o", out / "batch", "--jobs", 2, "--threads",
                                                threads, "--progress", "none", *given.options))
                else:
                    row = measured(lambda: two_singles(program, pieces, out, threads, given.options))
                row["load"] = os.getloadavg()[0]
                rows[what].append(row)
                print(f"round {number} {what:<8} {row['wall_s']:7.2f} s wall, {row['cpu_s']:7.2f} s CPU, load "
                      f"{row['load']:.1f}", file=sys.stderr)
            shutil.rmtree(out)
    result = {f"{what}_{unit}": statistics.median(row[unit] for row in rows[what])
              for what in rows for unit in ("wall_s", "cpu_s")}
    result["batch_over_singles_wall"] = statistics.median(
        b["wall_s"] / s["wall_s"] for b, s in zip(rows["batch"], rows["singles"]))
    result["batch_over_singles_cpu"] = statistics.median(
        b["cpu_s"] / s["cpu_s"] for b, s in zip(rows["batch"], rows["singles"]))
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
