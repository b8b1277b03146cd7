#!/usr/bin/env python3
"""`deepslam batch` on this machine: forty captures, six of them broken; resume, interruption, --keep final, usage.

    batch_test.py DEEPSLAM
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import fleet as fleets
from fleet import captures

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SKIPPED = 77
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-batch-")
DIR = pathlib.Path(TEMP.name)
PATIENCE_S = 1200


def batch(*arguments, **options):
    return captures.deepslam(PROGRAM, "batch", *arguments, timeout=PATIENCE_S, **options)


def start(*arguments):
    # AddressSanitizer would turn the fault that is sent here into an exit with code 1.
    return subprocess.Popen([PROGRAM, "batch", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            env=dict(os.environ, DEEPSLAM_DATA="/nonexistent", ASAN_OPTIONS="handle_segv=0"))


def wait_for(condition, what):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError(f"never came: {what}")


def running(root, name, in_stage=False):
    """The row of a capture that is at work; stages of less than a second may pass unseen."""
    state = fleets.batch_json(root)
    row = state and fleets.by_name(state)[name]
    return row if row and row["state"] == "running" and (row["stage"] or not in_stage) else None


class Forty(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.fleet = fleets.Fleet(ROOM, DIR / "forty")
        cls.root = DIR / "forty_batch"
        process = start(cls.fleet.list, "-o", cls.root, "--jobs", "2", "--threads", "2", *captures.BARE)
        # One capture's process dies as by a fault of the program.
        row = wait_for(lambda: running(cls.root, "crash", in_stage=True), "stage of `crash`")
        os.kill(row["process"], signal.SIGSEGV)
        cls.out, cls.err = process.communicate(timeout=PATIENCE_S)
        cls.code = process.returncode
        cls.state = fleets.batch_json(cls.root)
        cls.rows = fleets.by_name(cls.state)

    def test_good_ones_equal_single_runs(self):
        expected = fleets.single_runs(PROGRAM, self.fleet, DIR / "forty_single", captures.BARE, PATIENCE_S)
        self.assertEqual(len(expected), 34)
        for name, digests in expected.items():
            self.assertEqual(self.rows[name]["state"], "done")
            self.assertIn("export/scene.glb", digests)
            self.assertEqual(fleets.digests(self.root / name), digests, name)
        self.assertGreater(len({tuple(sorted(d.items())) for d in expected.values()}), 30, "the captures are not all one")

    def test_broken_ones_are_named_with_reasons(self):
        self.assertEqual(self.code, 1, self.err)
        failed = {name: row for name, row in self.rows.items() if row["state"] == "failed"}
        self.assertEqual(set(failed), set(self.fleet.broken))
        for name, part in self.fleet.broken.items():
            self.assertIn(part, failed[name]["reason"])
            self.assertIn(failed[name]["exit_code"], (1, 3))
            self.assertRegex(self.err, rf"error: \[\d+/40\] {name}: failed: ")
        self.assertEqual(len({row["reason"] for row in failed.values()}), 6, "each has a reason of its own")
        self.assertIn("Segmentation fault", failed["crash"]["reason"])
        self.assertIn("in stage", failed["crash"]["reason"])

    def test_table_and_document(self):
        self.assertEqual(self.state["counts"], {"all": 40, "done": 34, "failed": 6, "running": 0, "waiting": 0,
                                                "interrupted": 0})
        self.assertEqual(self.state["state"], "done")
        self.assertEqual(json.loads(self.out), self.state, "standard output is the document for programs")
        self.assertEqual([row["name"] for row in self.state["captures"]], self.fleet.names, "in the order of the list")
        for name in self.fleet.good:
            row = self.rows[name]
            self.assertIn(row["verdict"], ("good", "doubtful", "bad"))
            self.assertEqual(row["num_frames"], fleets.FRAMES_EACH)
            self.assertEqual(row["ate"]["num_scored"], fleets.FRAMES_EACH)
            self.assertLess(row["ate"]["rmse_m"], 0.1)
            self.assertGreater(row["wall_s"], 0)
            self.assertGreater(row["bytes"], 1000)

    def test_page_shows_all_and_links_what_is_there(self):
        page = (self.root / "index.html").read_text()
        for name, row in self.rows.items():
            self.assertIn(name, page)
        links = [link for link in re.findall(r"(?:href|src)='([^']*)'", page) if not link.startswith("data:")]
        self.assertEqual(sum(link.endswith("report/index.html") for link in links), 2 * 34, "thumbnail and name")
        for link in links:
            self.assertFalse(link.startswith("/") or "://" in link, link)
            self.assertTrue((self.root / link).exists(), link)
        self.assertEqual(page.count("data:image/jpeg;base64,"), 34)
        self.assertNotIn(str(DIR), page, "pages are passed on: no path of this machine")

    def test_rerun_tries_failed_ones_again_and_leaves_the_others(self):
        before = {name: fleets.digests(self.root / name) for name in self.fleet.good}
        times = {name: (self.root / name / "mesh" / "manifest.json").stat().st_mtime_ns for name in self.fleet.good}
        again = batch(self.fleet.list, "-o", self.root, "--jobs", "2", *captures.BARE)
        self.assertEqual(again.returncode, 1, again.stderr)
        rows = fleets.by_name(fleets.batch_json(self.root))
        self.assertEqual({name for name, row in rows.items() if row["state"] == "failed"}, set(self.fleet.broken) - {"crash"},
                         "what crashed is done now")
        for name in self.fleet.good:
            self.assertEqual((self.root / name / "mesh" / "manifest.json").stat().st_mtime_ns, times[name], "nothing ran")
            self.assertEqual(fleets.digests(self.root / name), before[name])
            self.assertEqual(rows[name]["wall_s"], self.rows[name]["wall_s"], "its time is that of the work, not of the look")


class Few(unittest.TestCase):
    number = 0

    def setUp(self):
        Few.number += 1
        self.dir = DIR / f"few{Few.number}"
        self.dir.mkdir()
        self.root = self.dir / "batch"

    def tearDown(self):
        shutil.rmtree(self.dir, ignore_errors=True)

    def cut(self, *names, frames=6):
        return [fleets.cut(ROOM, self.dir / name, 3 * i, frames) for i, name in enumerate(names)]

    def test_keep_final(self):
        rooms = self.cut("a", "b")
        whole = batch(*rooms, "-o", self.dir / "whole", *captures.BARE)
        self.assertEqual(whole.returncode, 0, whole.stderr)
        result = batch(*rooms, "-o", self.root, "--keep", "final", *captures.BARE)
        self.assertEqual(result.returncode, 0, result.stderr)
        for name in ("a", "b"):
            kept, all_files = fleets.digests(self.root / name), fleets.digests(self.dir / "whole" / name)
            for file in ("export/scene.glb", "export/map.json", "report/index.html", "optimize/trajectory.tum"):
                self.assertEqual(kept[file], all_files[file])
            self.assertNotIn("fuse/room.ply", kept)
            self.assertNotIn("track/trajectory.tum", kept)
            size = {root: sum(f.stat().st_size for f in (root / name).rglob("*") if f.is_file())
                    for root in (self.root, self.dir / "whole")}
            self.assertLess(size[self.root], size[self.dir / "whole"])
        times = (self.root / "a" / "export" / "manifest.json").stat().st_mtime_ns
        again = batch(*rooms, "-o", self.root, "--keep", "final", *captures.BARE)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.root / "a" / "export" / "manifest.json").stat().st_mtime_ns, times, "it knows that it is done")
        status = captures.deepslam(PROGRAM, "status", self.root / "a")
        states = {row["stage"]: row["state"] for row in json.loads(status.stdout)["stages"]}
        self.assertEqual((states["track"], states["export"]), ("dropped", "done"))
        # A changed option needs what was dropped: it comes back, and the result is that of a fresh run.
        changed = ("--set", "export.appearance=class")
        result = batch(*rooms, "-o", self.root, *captures.BARE, *changed)
        self.assertEqual(result.returncode, 0, result.stderr)
        fresh = batch(*rooms, "-o", self.dir / "fresh", *captures.BARE, *changed)
        self.assertEqual(fresh.returncode, 0, fresh.stderr)
        self.assertEqual(fleets.digests(self.root / "a")["export/scene.glb"],
                         fleets.digests(self.dir / "fresh" / "a")["export/scene.glb"])

    def interrupted(self, signal_number):
        rooms = self.cut("a", "b", "c", frames=40)
        arguments = (*rooms, "-o", self.root, "--jobs", "1", *captures.BARE)
        process = start(*arguments)
        tracked = self.root / "a" / "track" / "manifest.json"
        row = wait_for(lambda: tracked.exists() and running(self.root, "a"), "first stage of `a`")
        process.send_signal(signal_number)
        out, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 130, err)
        self.assertIn("run again to resume", err)
        self.assertFalse(pathlib.Path(f"/proc/{row['process']}").exists(), "no worker is left behind")
        state = fleets.batch_json(self.root)
        self.assertEqual(state["state"], "interrupted")
        self.assertEqual(fleets.by_name(state)["a"]["state"], "interrupted")
        self.assertEqual(fleets.by_name(state)["c"]["state"], "waiting")
        self.assertTrue((self.root / "index.html").exists())
        self.assertEqual([p.name for p in self.root.rglob("*.partial-*")], [])
        return arguments

    def test_sigint_is_130_and_resumes(self):
        arguments = self.interrupted(signal.SIGINT)
        track = (self.root / "a" / "track" / "manifest.json").stat().st_mtime_ns
        again = batch(*arguments)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.root / "a" / "track" / "manifest.json").stat().st_mtime_ns, track, "what was made stays")
        self.assertEqual(fleets.by_name(fleets.batch_json(self.root))["a"]["attempts"], 2)

    def test_sigterm_is_130(self):
        self.interrupted(signal.SIGTERM)

    def test_killed_coordinator_takes_its_workers_along_and_resumes(self):
        rooms = self.cut("a", "b", frames=40)
        arguments = (*rooms, "-o", self.root, "--jobs", "1", "--until", "select", *captures.BARE)
        process = start(*arguments)
        row = wait_for(lambda: running(self.root, "a"), "start of `a`")
        process.kill()
        process.communicate()
        wait_for(lambda: not pathlib.Path(f"/proc/{row['process']}").exists(), "end of the worker")
        again = batch(*arguments)
        self.assertEqual(again.returncode, 0, again.stderr)

    def test_worker_that_is_killed_is_told(self):
        rooms = self.cut("a", "b", frames=40)
        process = start(*rooms, "-o", self.root, "--jobs", "1", "--until", "select", *captures.BARE)
        os.kill(wait_for(lambda: running(self.root, "a"), "start of `a`")["process"], signal.SIGKILL)
        process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 1)
        rows = fleets.by_name(fleets.batch_json(self.root))
        self.assertIn("memory", rows["a"]["reason"])
        self.assertEqual(rows["b"]["state"], "done")

    def test_second_batch_in_the_same_folder_is_refused(self):
        rooms = self.cut("a", frames=40)
        process = start(*rooms, "-o", self.root, "--until", "select", *captures.BARE)
        wait_for(lambda: running(self.root, "a"), "start")
        second = batch(*rooms, "-o", self.root, *captures.BARE)
        self.assertEqual(second.returncode, 1)
        self.assertIn("another batch", second.stderr)
        process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 0, "the first is not disturbed")

    def test_workspace_of_something_else_is_left_alone(self):
        rooms = self.cut("a", "b")
        (self.root / "a").mkdir(parents=True)
        (self.root / "a" / "thesis.txt").write_text("x")
        result = batch(*rooms, "-o", self.root, "--until", "track", *captures.BARE)
        self.assertEqual(result.returncode, 1, result.stderr)
        rows = fleets.by_name(fleets.batch_json(self.root))
        self.assertIn("no workspace", rows["a"]["reason"])
        self.assertEqual(rows["b"]["state"], "done")
        self.assertEqual((self.root / "a" / "thesis.txt").read_text(), "x")

    def test_patterns_and_poses(self):
        self.cut("rooms/kitchen/seq-01", "rooms/office/seq-01")
        result = batch(self.dir / "rooms" / "*" / "seq-*", "-o", self.root, "--until", "track", "--poses", "capture",
                       *captures.BARE)
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = fleets.by_name(fleets.batch_json(self.root))
        self.assertEqual(set(rows), {"kitchen_seq-01", "office_seq-01"})
        self.assertNotIn("ate", rows["office_seq-01"], "given poses are not compared with themselves")

    def test_full_disk_is_told_before_the_start(self):
        rooms = self.cut("a")
        (self.dir / "a" / "huge.sens").touch()
        os.truncate(self.dir / "a" / "huge.sens", 2 ** 43)  # a hole: nothing is written
        result = batch(*rooms, "-o", self.root, "--until", "track", *captures.BARE)
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, r"will write about [\d.]+ GB, but [\d.]+ GB are free")
        self.assertIn("--keep final", result.stderr)
        self.assertFalse((self.root / "a").exists())

    def test_wrong_usage_is_2(self):
        rooms = self.cut("a")
        for arguments, text in (((), "CAPTURES"), ((*rooms,), "--output"),
                                ((*rooms, "-o", self.root, "--jobs", "-1"), "--jobs"),
                                ((*rooms, "-o", self.root, "--keep", "some"), "--keep"),
                                ((*rooms, "-o", self.root, "--until", "trak"), "stages are track"),
                                ((*rooms, "-o", self.root, "--set", "trak.x=1"), "unknown option"),
                                ((*rooms, "-o", self.dir / "a" / "capture.yaml"), "is a file")):
            result = batch(*arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(text, result.stderr)
        self.assertFalse(self.root.exists(), "nothing may be made of a wrong command")

    def test_unusable_list_is_3(self):
        lists = self.dir / "list.txt"
        for text, told in (("", "names no capture"), ("a b c d\n", "list.txt:1"), ("x/a\ny/a\n", "both have the workspace 'a'"),
                           ("none/*\n", "matches no folder")):
            lists.write_text(text)
            result = batch(lists, "-o", self.root)
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertIn(told, result.stderr)
        self.assertEqual(batch(self.dir / "none.txt", "-o", self.root).returncode, 3)
        self.assertFalse(self.root.exists())


if __name__ == "__main__":
    ROOM = fleets.render(PROGRAM, DIR / "room")
    if ROOM is None:
        print("skipped: the furniture catalogues (Debian package sweethome3d-furniture) are not installed")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
