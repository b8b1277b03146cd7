#!/usr/bin/env python3
"""`deepslam batch --engine slurm` on a real Slurm of two nodes, one of which is lost in the middle.

    slurm_test.py DEEPSLAM
"""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import fleet as fleets
import slurm_cluster
from fleet import captures

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SKIPPED = 77
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-slurm-")
DIR = pathlib.Path(TEMP.name)
PATIENCE_S = 600
# The chain to its most expensive stages, so that the test stays short.
CHAIN = (*captures.BARE, "--until", "select")
OPTIONS = (*CHAIN, "--threads", "1")  # a node has one processor


def start(*arguments):
    # AddressSanitizer would turn the fault that is sent below into an exit with code 1.
    environment = dict(CLUSTER.environment, DEEPSLAM_DATA="/nonexistent", ASAN_OPTIONS="handle_segv=0")
    return subprocess.Popen([PROGRAM, "batch", *map(str, arguments), "--engine", "slurm"], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, env=environment)


def records(root):
    """What the tasks say of themselves."""
    found = {}
    for file in (root / ".batch" / "records").glob("*.json"):
        record = json.loads(file.read_text())["record"]
        found[record["name"]] = record
    return found


def wait_for(condition, what):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"never came: {what}")


def running_on(root, node):
    return [row for row in records(root).values() if row["state"] == "running" and row["host"] == node and
            pathlib.Path(f"/proc/{row['process']}").exists()]


class LostNode(unittest.TestCase):
    """Forty captures; one crashes, five are broken, and one of the two nodes goes down with what it works on."""

    @classmethod
    def setUpClass(cls):
        cls.fleet = fleets.Fleet(ROOM, DIR / "forty")
        cls.root = DIR / "forty_batch"
        process = start(cls.fleet.list, "-o", cls.root, "--jobs", "2", "--time", "30", *OPTIONS)
        crashing = wait_for(lambda: [row for row in records(cls.root).values() if row["name"] == "crash" and
                                     row["state"] == "running"], "start of `crash`")
        os.kill(crashing[0]["process"], signal.SIGSEGV)
        wait_for(lambda: sum(row["state"] == "done" for row in records(cls.root).values()) >= 6, "the first six")
        cls.lost = wait_for(lambda: running_on(cls.root, "n2"), "work on n2")
        cls.steps = CLUSTER.lose("n2")
        cls.out, cls.err = process.communicate(timeout=PATIENCE_S)
        cls.code = process.returncode
        cls.rows = fleets.by_name(fleets.batch_json(cls.root))

    def test_node_was_lost_and_its_work_began_again_elsewhere(self):
        self.assertTrue(self.steps, "something ran on the node")
        self.assertTrue(CLUSTER.states()["n2"].startswith("down"), CLUSTER.states())
        again = [row for row in self.rows.values() if row["attempts"] > 1]
        self.assertEqual({row["name"] for row in again}, {row["name"] for row in self.lost})
        for row in again:
            self.assertEqual((row["state"], row["host"]), ("done", "n1"))
        self.assertEqual({row["host"] for row in self.rows.values() if row["state"] == "done"}, {"n1", "n2"})

    def test_good_ones_equal_single_runs(self):
        expected = fleets.single_runs(PROGRAM, self.fleet, DIR / "forty_single", CHAIN, PATIENCE_S)
        self.assertEqual(len(expected), 34)
        for name, digests in expected.items():
            self.assertEqual(self.rows[name]["state"], "done", self.rows[name]["reason"])
            self.assertIn("select/objects.json", digests)
            self.assertEqual(fleets.digests(self.root / name), digests, name)

    def test_broken_ones_are_named_with_reasons(self):
        self.assertEqual(self.code, 1, self.err)
        failed = {name: row for name, row in self.rows.items() if row["state"] == "failed"}
        self.assertEqual(set(failed), set(self.fleet.broken), self.err)
        for name, part in self.fleet.broken.items():
            self.assertIn(part, failed[name]["reason"])
            self.assertIn(f"{name}: failed", self.err)

    def test_summary_job_wrote_page_and_table(self):
        self.assertTrue((self.root / "index.html").exists())
        state = fleets.batch_json(self.root)
        self.assertEqual((state["engine"], state["state"]), ("slurm", "done"))
        self.assertEqual(state["counts"]["done"], 34)
        logs = list((self.root / ".batch" / "logs").glob("slurm-summary-*.log"))
        self.assertEqual(len(logs), 1)
        self.assertIn("34 of 40 done, 6 failed", logs[0].read_text())

    def test_tasks_went_through_an_array_with_its_limit(self):
        submitted = re.search(r"as job (\d+) of Slurm, the summary as job (\d+)", self.err)
        job = CLUSTER.run("scontrol", "show", "job", "-o", f"{submitted[1]}_0").stdout
        self.assertIn("ArrayTaskThrottle=2", job)
        self.assertIn("Requeue=1", job)
        self.assertIn("TimeLimit=00:30:00", job)


class OneNode(unittest.TestCase):
    """What one node is enough for: the one that is left."""

    def setUp(self):
        self.dir = pathlib.Path(tempfile.mkdtemp(dir=DIR))
        self.root = self.dir / "batch"

    def cut(self, *names, frames=fleets.FRAMES_EACH):
        return [fleets.cut(ROOM, self.dir / name, 3 * i, frames) for i, name in enumerate(names)]

    def test_interrupt_cancels_the_jobs_and_a_second_call_resumes(self):
        rooms = self.cut("a", "b", "c", frames=40)
        arguments = (*rooms, "-o", self.root, "--jobs", "1", *OPTIONS)
        process = start(*arguments)
        worker = wait_for(lambda: [row for row in records(self.root).values() if row["state"] == "running"], "start")[0]
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 130, err)
        self.assertEqual(CLUSTER.run("squeue", "--noheader").stdout, "", "no job is left behind")
        self.assertFalse(pathlib.Path(f"/proc/{worker['process']}").exists())
        process = start(*arguments)
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 0, err)
        self.assertEqual(fleets.batch_json(self.root)["counts"]["done"], 3)

    def test_no_wait_leaves_all_to_slurm_and_a_second_call_watches(self):
        rooms = self.cut("a", "b", frames=40)
        arguments = (*rooms, "-o", self.root, "--per-task", "2", *OPTIONS)
        process = start(*arguments, "--no-wait")
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 0, err)
        jobs = re.search(r"as job (\d+) of Slurm, the summary as job (\d+)", err).groups()
        other = start(*rooms[:1], "-o", self.root, *OPTIONS)
        _, err = other.communicate(timeout=PATIENCE_S)
        self.assertEqual(other.returncode, 1)
        self.assertIn(f"scancel {jobs[0]} {jobs[1]}", err)
        watching = start(*arguments)
        _, err = watching.communicate(timeout=PATIENCE_S)
        self.assertEqual(watching.returncode, 0, err)
        self.assertIn(f"jobs {jobs[0]} and {jobs[1]} of this batch are at work", err)
        self.assertEqual(fleets.batch_json(self.root)["counts"]["done"], 2)

    def test_task_that_is_cancelled_is_told(self):
        rooms = self.cut("a", "b", frames=40)
        process = start(*rooms, "-o", self.root, "--jobs", "1", *OPTIONS)
        wait_for(lambda: [row for row in records(self.root).values() if row["state"] == "running"], "start")
        array = json.loads((self.root / ".batch" / "jobs.json").read_text())["array_id"]
        CLUSTER.run("scancel", f"{array}_0")
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 1, err)
        rows = fleets.by_name(fleets.batch_json(self.root))
        self.assertEqual(rows["b"]["state"], "done")
        self.assertEqual(rows["a"]["state"], "failed")
        self.assertIn("CANCELLED", rows["a"]["reason"])

    def test_what_sbatch_refuses_is_told(self):
        process = start(*self.cut("a"), "-o", self.root, "--partition", "nowhere", *OPTIONS)
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 1)
        self.assertIn("invalid partition", err)


class WithoutSlurm(unittest.TestCase):
    def test_missing_sbatch_is_2_and_says_what_to_do(self):
        folder = pathlib.Path(tempfile.mkdtemp(dir=DIR))
        capture = fleets.cut(ROOM, folder / "a", 0, 4)
        result = subprocess.run([PROGRAM, "batch", capture, "-o", folder / "batch", "--engine", "slurm"], text=True,
                                capture_output=True, env={"PATH": "/nonexistent", "HOME": str(folder)}, timeout=60)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("sbatch", result.stderr)
        self.assertIn("--engine local", result.stderr)


if __name__ == "__main__":
    if slurm_cluster.missing():
        print(f"skipped: {', '.join(slurm_cluster.missing())} not installed (Debian packages slurm-wlm and munge; "
              "scripts/setup.sh --tests installs them)")
        sys.exit(SKIPPED)
    ROOM = fleets.render(PROGRAM, DIR / "room")
    if ROOM is None:
        print("skipped: the furniture catalogues (Debian package sweethome3d-furniture) are not installed")
        sys.exit(SKIPPED)
    CLUSTER = slurm_cluster.Cluster(DIR / "cluster")
    try:
        started = CLUSTER.start()
        if started is not True:
            print(f"a Slurm of two nodes does not start on this machine: {started}")
            sys.exit(1)
        # LostNode comes first: its name sorts before the others.
        outcome = unittest.main(argv=sys.argv[:1] + sys.argv[2:], exit=False).result
    finally:
        CLUSTER.stop()
    sys.exit(0 if outcome.wasSuccessful() else 1)
