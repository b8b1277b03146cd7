#!/usr/bin/env python3
"""The scene file in the hands of others: the Khronos validator, and three.js in a headless Chromium.

    web_test.py DEEPSLAM REPOSITORY

The validator cannot look into Draco, so it gets the uncompressed copy as well.
"""
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

import captures
import surfaces

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SCRIPTS = pathlib.Path(sys.argv[2]).resolve() / "scripts"
SKIPPED = 77
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-web-")
DIR = pathlib.Path(TEMP.name)
EXPORT = DIR / "workspace" / "export"


def script(name, *arguments):
    return subprocess.run([SCRIPTS / name, *map(str, arguments)], capture_output=True, text=True, timeout=1200)


class Scene(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        boxes = DIR / "boxes.json"
        boxes.write_text(json.dumps(captures.true_boxes(ROOM)))
        result = captures.deepslam(PROGRAM, "run", ROOM, "-o", DIR / "workspace", "--set", "propose.retrieval=false", "--set",
                                   "detect.source=file", "--set", f"detect.file={boxes}", "--progress", "none", timeout=1200)
        assert result.returncode == 0, result.stderr
        cls.objects = json.loads((EXPORT / "map.json").read_text())["objects"]
        assert cls.objects, "the room has furniture"

    def test_khronos_validator_finds_nothing(self):
        result = script("validate_gltf.sh", EXPORT / "scene.glb", EXPORT / "scene.uncompressed.glb")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        reports = [json.loads(line) for line in result.stdout.splitlines()]
        self.assertEqual(len(reports), 2)
        for report in reports:
            self.assertEqual((report["errors"], report["warnings"]), (0, 0), report["messages"])

    def test_validator_would_find_a_fault(self):
        broken = DIR / "broken.glb"
        data = (EXPORT / "scene.uncompressed.glb").read_bytes()
        self.assertIn(b'"bufferView":0', data)
        broken.write_bytes(data.replace(b'"bufferView":0', b'"bufferView":9', 1))
        self.assertNotEqual(script("validate_gltf.sh", broken).returncode, 0)

    def test_three_loads_it_with_its_labels(self):
        picture = DIR / "scene.png"
        result = script("render_glb.sh", EXPORT / "scene.glb", picture)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        scene = json.loads(result.stdout)
        self.assertTrue(scene["ok"])
        self.assertEqual(scene["console_errors"], [])
        nodes = {node["name"]: node for node in scene["nodes"]}
        for thing in self.objects:
            node = nodes[thing["name"]]
            self.assertEqual(node["extras"]["class"], thing["class"])
            for label in ("instance", "score", "prior", "views"):
                self.assertIn(label, node["extras"])
            # Draco was decoded: faces are there.
            self.assertGreater(faces_below(scene["nodes"], thing["name"]), 100)
        for name in ("ground", "room", "trajectory"):
            self.assertIn(name, nodes)
        width, height = struct.unpack(">II", picture.read_bytes()[16:24])
        self.assertEqual((width, height), (1200, 900))

    def test_objects_are_closed_two_manifolds_by_another_count(self):
        found = surfaces.objects(EXPORT / "scene.uncompressed.glb")
        self.assertEqual(sorted(found), sorted(thing["name"] for thing in self.objects))
        for name, faces in found.items():
            self.assertGreater(len(faces), 100, name)
            self.assertEqual(surfaces.faults(faces), [], name)
            self.assertGreater(surfaces.volume(faces), 0, name)
            self.assertNotEqual(surfaces.faults(faces[1:]), [], "the count would notice a hole")

    def test_scene_is_draco_and_its_copy_is_not(self):
        self.assertIn(b"KHR_draco_mesh_compression", (EXPORT / "scene.glb").read_bytes())
        self.assertNotIn(b"KHR_draco_mesh_compression", (EXPORT / "scene.uncompressed.glb").read_bytes())


def faces_below(nodes, name):
    """Faces of a node, or of the parts that three.js lists right behind it."""
    at = next(i for i, node in enumerate(nodes) if node["name"] == name)
    if nodes[at]["faces"]:
        return nodes[at]["faces"]
    return next((node["faces"] for node in nodes[at + 1:] if node["faces"]), 0)


if __name__ == "__main__":
    chromium = os.environ.get("CHROMIUM") or next(
        filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    for what, there in (("chromium", chromium), ("node", shutil.which("node"))):
        if not there:
            print(f"skipped: {what} is not installed; scripts/setup.sh --tests installs it")
            sys.exit(SKIPPED)
    ROOM = captures.make_room(PROGRAM, DIR / "room")
    if ROOM is None:
        print("skipped: the furniture catalogues (Debian package sweethome3d-furniture) are not installed")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
