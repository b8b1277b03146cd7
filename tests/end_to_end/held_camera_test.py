#!/usr/bin/env python3
"""The demo's room recorded by a camera that lies on its side or hangs upside down: the same furniture, in the same places.

    held_camera_test.py DEEPSLAM REPOSITORY

Exit 77: catalogues, furniture library or weights are not installed.
"""
import json
import pathlib
import sys
import tempfile
import unittest

import captures

PROGRAM, REPOSITORY = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
SKIPPED = 77
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-held-")
DIR = pathlib.Path(TEMP.name)
CAMERA = "cy: 239.5}"


def missing(done):
    """What is not installed, of a command that says so."""
    return done.returncode == 3 and any(word in done.stderr for word in ("sweethome3d-furniture", "fetch", "library build"))


class HeldCamera(unittest.TestCase):
    def call(self, *arguments):
        done = captures.deepslam(PROGRAM, *arguments, data=None)
        if missing(done):
            self.skipTest(done.stderr.strip())
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def record(self, roll_deg):
        """40 frames, so that the room is done in seconds."""
        text = (REPOSITORY / "configs" / "scenes" / "demo_room.yaml").read_text()
        assert text.count(CAMERA) == 1 and text.count("frames: 120") == 1
        text = text.replace(CAMERA, CAMERA.replace("}", f", roll_deg: {roll_deg}}}")).replace("frames: 120", "frames: 40")
        scene = DIR / f"rolled_{roll_deg}.yaml"
        scene.write_text(text)
        self.call("synth", scene, "-o", scene.with_suffix(""))
        return scene.with_suffix("")

    def expect_the_room(self, roll_deg):
        capture = self.record(roll_deg)
        workspace = DIR / f"{capture.name}_map"
        self.call("run", capture, "-o", workspace, "--progress", "none")
        found = json.loads(self.call("eval", "objects", workspace, capture))
        for row in found["classes"]:
            self.assertEqual((row["num_found"], row["num_mapped"]), (row["num_true"], row["num_true"]), row)
        self.assertGreaterEqual(sum(row.get("placed", False) for row in found["objects"]), 3)
        ground = json.loads((workspace / "export" / "map.json").read_text())["ground_world"]
        self.assertGreater(ground["normal"][2], 0.9999)

    def test_on_its_side(self):
        self.expect_the_room(90)

    def test_upside_down(self):
        self.expect_the_room(180)


if __name__ == "__main__":
    outcome = unittest.main(argv=sys.argv[:1], verbosity=2, exit=False).result
    sys.exit(1 if not outcome.wasSuccessful() else SKIPPED if outcome.skipped else 0)
