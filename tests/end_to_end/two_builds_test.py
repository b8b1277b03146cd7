#!/usr/bin/env python3
"""two_builds.py: a build beside itself makes the same bytes; one that differs is told, with the stages where it does.

    two_builds_test.py DEEPSLAM REPOSITORY

Exit 77: the furniture catalogues are not installed.
"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import captures

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SCRIPT = pathlib.Path(__file__).with_name("two_builds.py")
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-two-builds-test-")
DIR = pathlib.Path(TEMP.name)
ROOM = captures.make_room(PROGRAM, DIR / "room")


def stand_in(name, *more, afterwards="true"):
    """The program with other options, or with something done to its workspace: what another build might make of a capture."""
    file = DIR / name
    file.write_text(f'#!/bin/sh\n"{PROGRAM}" "$@" {" ".join(more)} || exit\nworkspace="$4"\n{afterwards}\n')
    file.chmod(0o755)
    return file


def compare(other):
    return subprocess.run([sys.executable, "-B", SCRIPT, PROGRAM, other, ROOM, "--", *captures.BARE], capture_output=True, text=True,
                          timeout=600)


class TwoBuilds(unittest.TestCase):
    def test_a_build_beside_itself(self):
        done = compare(PROGRAM)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("0 differences beyond the tolerances; the same bytes in every stage", done.stdout)

    def test_stages_whose_bytes_differ_are_named(self):
        done = compare(stand_in("coarse", "--set", "fuse.voxel_m=0.04"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, "0 differences beyond the tolerances; bytes differ in fuse, export")

    def test_another_ground_is_a_difference(self):
        lifted = """sed -i 's/"d_m": /"d_m": 1/' "$workspace/export/map.json\""""
        done = compare(stand_in("lifted", afterwards=lifted))
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stdout, r"1 differences beyond the tolerances; bytes differ in export\n +the ground is at ")

    def test_a_build_that_fails_is_told(self):
        done = compare(stand_in("failing", "--set", "no.such.option=1"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("failing ended with 2", done.stderr)


if __name__ == "__main__":
    if ROOM is None:
        print("skipped: the furniture catalogues are not installed")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
