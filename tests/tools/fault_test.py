#!/usr/bin/env python3
"""Kills, interrupts and lets disks fail under `deepslam run`, and checks that the run after it ends in the bytes of an
undisturbed one.

    fault_test.py DEEPSLAM [--capture DIR] [--kills N] [--faults N] [--read-faults N] [--signals N] [--seed S] [--shim LIBRARY] [--log FILE]
                  [-- more arguments of `deepslam run`]

Each trial begins with a whole workspace that lacks one stage and all after it (the stages take turns), and starts the
run of that stage.
- kills: SIGKILL at a random moment, in turn of the whole process, inside the stage, and while the stage writes; after
  every other kill the newest file is cut at a random byte, as power loss does to what was not yet on the disk.
- signals: SIGINT or SIGTERM inside the stage: exit code 130, a message, nothing half done left.
- faults: with --shim (tests/tools/fault_shim.c) a random writing call fails with ENOSPC, and all after it, or with EIO;
  exit code 1 and a message that names a file, nothing half done left.
- read faults: with --shim a random call that reads below the capture fails with EIO: exit code 1 and a message that names
  the file, nothing half done left, and no result made without that frame.
--log gets one line per trial: what, stage, bytes written so far. Without --capture a room of ten frames is rendered.
Exit 77: nothing to test with.
"""
import argparse
import collections
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "end_to_end")]
import captures  # noqa: E402
import kill_test  # noqa: E402

STAGES = kill_test.STAGES
NOT_A_LOSS = {"timing.json", "timing.html", ".lock"}


class Trials:
    def __init__(self, program, capture, folder, more, log):
        self.program, self.capture, self.folder, self.more, self.log = program, capture, folder, more, log
        self.whole = folder / "whole"
        self.workspace = folder / "workspace"
        self.failures = []
        self.process_s = {}  # stage -> time of the last run of it
        kill_test.run_to_end(program, capture, self.whole, 2, more)
        self.expected = kill_test.digests(self.whole)
        self.bytes_lost = 0

    def prepare(self, stage):
        """The workspace of a run that ended just before the stage."""
        shutil.rmtree(self.workspace, ignore_errors=True)
        shutil.copytree(self.whole, self.workspace)
        for later in STAGES[STAGES.index(stage):]:
            shutil.rmtree(self.workspace / later)

    def start(self, stage, **options):
        arguments = kill_test.command(self.program, self.capture, self.workspace, 2, ["--until", stage, *self.more])
        return subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace",
                                **options)

    def partial(self, stage, process):
        return self.workspace / f"{stage}.partial-{process.pid}"

    def wait_inside(self, stage, process, writing=False):
        """False when it ended before the stage began (writing: before it wrote), or was too fast."""
        partial = self.partial(stage, process)
        while process.poll() is None:
            if partial.exists() and (not writing or kill_test.bytes_below(partial) > 0):
                return True
            time.sleep(0.0002)
        return False

    def note(self, text):
        if self.log:
            print(text, file=self.log, flush=True)

    def fail(self, text):
        self.failures.append(text)
        print("FAILED", text, flush=True)

    def leftovers(self):
        return [path.name for path in self.workspace.iterdir() if ".partial-" in path.name or ".old-" in path.name
                or ".tmp-" in path.name]

    def check_rerun(self, stage, what):
        """Runs the stage again and compares all that there is."""
        begin = time.monotonic()
        again = self.start(stage)
        _, message = again.communicate()
        self.process_s[stage] = time.monotonic() - begin
        if again.returncode != 0:
            self.bytes_lost += sum(file.stat().st_size for file in self.whole.rglob("*") if file.is_file())
            return self.fail(f"{what}: the run after it ended with {again.returncode}: {message.strip()[-400:]}")
        there = STAGES[:STAGES.index(stage) + 1]
        expected = {name: digest for name, digest in self.expected.items()
                    if name.split("/")[0] not in STAGES or name.split("/")[0] in there}
        found = kill_test.digests(self.workspace)
        differing = sorted(name for name in expected.keys() | found.keys() if expected.get(name) != found.get(name))
        for name in differing:
            file = self.whole / name
            self.bytes_lost += file.stat().st_size if file.exists() else 0
        if differing:
            self.fail(f"{what}: differing files: {', '.join(differing[:5])}")
        if left := self.leftovers():
            self.fail(f"{what}: left over: {', '.join(left)}")

    def place_of(self, kind):
        return self.capture.resolve() if kind == "read" else self.workspace

    def duration_s(self, stage):
        """Of the stage in the undisturbed run."""
        return json.loads((self.whole / stage / "timing.json").read_text())["wall_s"]


def cut_newest(workspace, chance):
    """Cuts the file that was written last, or the one that a stage wrote last; its name and the bytes that are left."""
    below_stages = chance.random() < 0.5
    files = [file for file in workspace.rglob("*") if file.is_file() and file.name != ".lock"
             and (not below_stages or file.parent != workspace)]
    if not files:
        return "nothing to cut"
    newest = max(files, key=lambda file: (file.stat().st_mtime_ns, str(file)))
    size = newest.stat().st_size
    left = chance.randrange(size) if size else 0
    os.truncate(newest, left)
    return f"{newest.relative_to(workspace)} cut from {size} to {left} bytes"


def kill(trials, stage, number, chance):
    trials.prepare(stage)
    process = trials.start(stage)
    if number % 3 == 0:
        time.sleep(chance.uniform(0, trials.process_s.get(stage, trials.duration_s(stage) + 0.1)))
    elif trials.wait_inside(stage, process, writing=number % 3 == 2):
        time.sleep(chance.uniform(0, 0.01 if number % 3 == 2 else trials.duration_s(stage)))
    process.send_signal(signal.SIGKILL)
    process.communicate()
    ended = process.returncode != -signal.SIGKILL
    partial = trials.partial(stage, process)
    inside = partial.exists()
    written = kill_test.bytes_below(partial) if inside else 0
    cut = cut_newest(trials.workspace, chance) if chance.random() < 0.5 else "nothing cut"
    place = f"inside {stage}" if inside else f"after {stage}" if ended or (trials.workspace / stage).exists() else f"before {stage}"
    what = f"kill {number}: {place}, {written} bytes written, {cut}"
    trials.note(what)
    trials.check_rerun(stage, what)
    return inside, written


def interrupt(trials, stage, number, chance):
    """Whether the signal met a running process."""
    trials.prepare(stage)
    process = trials.start(stage)
    if trials.wait_inside(stage, process) and number % 3:
        time.sleep(chance.uniform(0, 0.5 * trials.duration_s(stage)))
    which = (signal.SIGINT, signal.SIGTERM)[number % 2]
    process.send_signal(which)
    _, message = process.communicate()
    code = process.returncode
    what = f"{which.name} in {stage}: exit {code}"
    trials.note(what)
    # A stage that is in its last step ends as if nothing had happened.
    if code not in (130, 0):
        trials.fail(f"{what}: {message.strip()[-300:]}")
    if code == 130 and "run again" not in message:
        trials.fail(f"{what}: does not say how to go on: {message.strip()[-300:]}")
    if left := trials.leftovers():
        trials.fail(f"{what}: left over: {', '.join(left)}")
    trials.check_rerun(stage, what)
    return code == 130


def count_calls(trials, stage, shim, kind="write"):
    counted = trials.folder / "calls"
    trials.prepare(stage)
    process = trials.start(stage, env=fault_environment(shim, trials.place_of(kind), 0, "EIO", counted, kind))
    _, message = process.communicate()
    if process.returncode:
        sys.exit(f"the run with {shim} ended with {process.returncode}: {message}")
    return int(counted.read_text().split()[0])


def fault_environment(shim, folder, at, error, counted, kind="write"):
    return dict(os.environ, LD_PRELOAD=str(shim), DEEPSLAM_FAULT_BELOW=str(folder), DEEPSLAM_FAULT_AT=str(at),
                DEEPSLAM_FAULT_ERROR=error, DEEPSLAM_FAULT_CALLS=kind, DEEPSLAM_FAULT_COUNT=str(counted))


def disk_fault(trials, stage, number, chance, shim, calls):
    trials.prepare(stage)
    error = ("ENOSPC", "EIO")[number % 2]
    at = chance.randint(1, calls)
    counted = trials.folder / "calls"
    process = trials.start(stage, env=fault_environment(shim, trials.workspace, at, error, counted))
    _, message = process.communicate()
    code = process.returncode
    call = counted.read_text().split()[1] if counted.exists() else "unknown"
    what = f"{error} at call {at} of {calls} ({call}) in {stage}: exit {code}"
    trials.note(what)
    reason = {"ENOSPC": "No space left", "EIO": "Input/output error"}[error]
    if call == "none":
        pass  # the run needed fewer calls this time
    elif code != 1:
        trials.fail(f"{what}: {message.strip()[-300:]}")
    elif str(trials.workspace) not in message or reason not in message:
        trials.fail(f"{what}: does not name file and reason: {message.strip()[-300:]}")
    # What a broken disk does not let go is taken away by the next run.
    if error == "EIO" and (left := trials.leftovers()):
        trials.fail(f"{what}: left over: {', '.join(left)}")
    trials.check_rerun(stage, what)
    return call


def read_fault(trials, stage, chance, shim, calls):
    trials.prepare(stage)
    at = chance.randint(1, calls)
    counted = trials.folder / "calls"
    capture = trials.place_of("read")
    process = trials.start(stage, env=fault_environment(shim, capture, at, "EIO", counted, "read"))
    _, message = process.communicate()
    code = process.returncode
    call = counted.read_text().split()[1] if counted.exists() else "unknown"
    what = f"EIO at reading call {at} of {calls} ({call}) before or in {stage}: exit {code}"
    trials.note(what)
    if call != "none" and code != 1:
        trials.fail(f"{what}: {message.strip()[-300:]}")
    elif call != "none" and (str(capture) not in message or "Input/output error" not in message):
        trials.fail(f"{what}: does not name file and reason: {message.strip()[-300:]}")
    if left := trials.leftovers():
        trials.fail(f"{what}: left over: {', '.join(left)}")
    trials.check_rerun(stage, what)
    return call


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--capture", type=pathlib.Path)
    parser.add_argument("--kills", type=int, default=len(STAGES))
    parser.add_argument("--signals", type=int, default=6)
    parser.add_argument("--faults", type=int, default=6)
    parser.add_argument("--read-faults", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--shim", type=pathlib.Path)
    parser.add_argument("--log", type=pathlib.Path)
    parser.add_argument("more", nargs="*", default=list(captures.BARE))
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    chance = random.Random(options.seed)
    with tempfile.TemporaryDirectory(prefix="deepslam-fault-") as temp:
        temp = pathlib.Path(temp).resolve()
        capture = options.capture or captures.make_room(program, temp / "room")
        if capture is None:
            print("skipped: no furniture catalogues; install sweethome3d-furniture or pass --capture")
            return 77
        trials = Trials(program, capture, temp, options.more, options.log and options.log.open("w"))

        hits, most, num_kills = collections.Counter(), 0, 0
        for number in range(options.kills):
            # One further in every round, so that each stage is met in each of the three ways.
            stage = STAGES[(number + number // len(STAGES)) % len(STAGES)]
            # Stages too short for the clock are tried again.
            for _ in range(3):
                inside, written = kill(trials, stage, number, chance)
                num_kills += 1
                hits[stage] += inside
                most = max(most, written)
                if inside or number % 3 == 0:
                    break
        print(f"kills     {num_kills}; inside a stage {sum(hits.values())}: "
              f"{', '.join(f'{stage} {hits[stage]}' for stage in STAGES)}; most bytes written {most}", flush=True)
        # In stages that last long enough to be met.
        longest = sorted(STAGES, key=trials.duration_s)[-5:]
        stopped = sum(interrupt(trials, longest[number % len(longest)], number, chance) for number in range(options.signals))
        print(f"signals   {options.signals}, of which {stopped} ended a stage with 130", flush=True)
        if options.signals > len(longest) and not stopped:
            trials.fail("no signal ended a run")
        if options.shim and options.faults:
            met, calls = collections.Counter(), {}
            for number in range(options.faults):
                stage = STAGES[number * 4 % len(STAGES)]  # 4 and 15 have no divisor: every stage
                calls.setdefault(stage, count_calls(trials, stage, options.shim.resolve()))
                met[disk_fault(trials, stage, number, chance, options.shim.resolve(), calls[stage])] += 1
            print(f"faults    {options.faults} (ENOSPC and EIO): {', '.join(f'{call} {met[call]}' for call in sorted(met))}",
                  flush=True)
        if options.shim and options.read_faults:
            met, calls = collections.Counter(), {}
            # Stages that look at frames; the first calls of every run are those that open and hash the capture.
            readers = ["track", "detect", "propose", "fuse"]
            for number in range(options.read_faults):
                stage = readers[number % len(readers)]
                calls.setdefault(stage, count_calls(trials, stage, options.shim.resolve(), "read"))
                met[read_fault(trials, stage, chance, options.shim.resolve(), calls[stage])] += 1
            print(f"read EIO  {options.read_faults}: {', '.join(f'{call} {met[call]}' for call in sorted(met))}", flush=True)
        print(f"failures  {len(trials.failures)}; bytes lost {trials.bytes_lost}")
        return 1 if trials.failures else 0


if __name__ == "__main__":
    sys.exit(main())
