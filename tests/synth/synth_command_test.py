#!/usr/bin/env python3
"""`deepslam synth` with furniture of the user's: files in folders, and what is wrong with them.

    synth_command_test.py DEEPSLAM
"""
import base64
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

DEEPSLAM = sys.argv[1]
SCENE = """seed: 5
frames: {frames}
frames_per_s: 10
camera: {{preset: {preset}, width: 64, height: 48, fx: 52, fy: 52, cx: 31.5, cy: 23.5}}
room: {{size_m: [5, 5, 2.5], posters: 0}}
lights: [{{position_m: [0.5, 0.5, 2.4], power: 2}}]
objects:
{objects}
orbit: {{radius_m: {radius}, height_m: {height}, sweep_deg: 40}}
"""
# A box of 0.6 x 0.8 x 0.4 (x left, y up, z front), outer faces.
CORNERS = [(x, y, z) for x in (-0.3, 0.3) for y in (0.0, 0.8) for z in (-0.2, 0.2)]
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FACES = [face for a, b, c, d in QUADS for face in ((a, b, c), (a, c, d))]


def obj(vertices, faces):
    return ("".join(f"v {x} {y} {z}\n" for x, y, z in vertices) +
            "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces))


def gltf(uri=None):
    """The box's JSON and buffer, in centimetres under a node that brings it to metres."""
    positions = b"".join(struct.pack("<3f", *(100 * c for c in corner)) for corner in CORNERS)
    indices = b"".join(struct.pack("<3H", *face) for face in FACES)
    buffer = {"byteLength": len(positions) + len(indices)}
    if uri:
        buffer["uri"] = uri
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                "nodes": [{"scale": [0.01, 0.01, 0.01], "children": [1]}, {"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
                "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.3, 0.1, 1]}}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8},
                              {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 36}],
                "bufferViews": [{"buffer": 0, "byteLength": len(positions)},
                                {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
                "buffers": [buffer]}
    return document, positions + indices


def glb(document, buffer):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    buffer += b"\0" * (-len(buffer) % 4)
    return (struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(buffer), len(text), 0x4E4F534A) + text +
            struct.pack("<II", len(buffer), 0x004E4942) + buffer)


class Synth(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.furniture = self.root / "furniture"
        (self.furniture / "chairs").mkdir(parents=True)
        self.num_captures = 0

    def synth(self, *objects, frames=1, preset="kinect_v1", radius=1.9, height=1.5, more=(), before=()):
        """Exit code, messages, capture folder."""
        scene = self.root / "scene.yaml"
        lines = "\n".join("  - {" + entry + "}" for entry in objects)
        scene.write_text(SCENE.format(frames=frames, preset=preset, objects=lines, radius=radius, height=height))
        self.num_captures += 1
        capture = self.root / f"capture{self.num_captures}"
        done = subprocess.run([*before, DEEPSLAM, "synth", scene, "-o", capture, "--furniture", self.furniture,
                               "--catalogues", self.root / "none", *more],
                              capture_output=True, text=True, check=False)
        return done.returncode, done.stderr, capture

    def chair(self, name):
        return f"class: chair, model: \"{name}\", position_m: [0, 0], yaw_deg: 30"

    def assert_refused(self, name, *words, code=3):
        found, stderr, capture = self.synth(self.chair(name))
        self.assertEqual(found, code, stderr)
        for word in words:
            self.assertIn(word, stderr)
        self.assertFalse(capture.exists(), "nothing half-written")

    def assert_stands(self, name):
        code, stderr, capture = self.synth(self.chair(name))
        self.assertEqual(code, 0, stderr)
        truth = json.loads((capture / "truth/objects.json").read_text())["objects"][0]
        for size, expected in zip(truth["size_m"], (0.4, 0.6, 0.8)):
            self.assertAlmostEqual(size, expected, 5)
        return capture

    def test_obj_gltf_and_glb_are_the_same_furniture(self):
        (self.furniture / "chairs/box.obj").write_text(obj(CORNERS, FACES))
        document, buffer = gltf("box data.bin")
        document["buffers"][0]["uri"] = "box%20data.bin"
        (self.furniture / "chairs/box.gltf").write_text(json.dumps(document))
        (self.furniture / "chairs/box data.bin").write_bytes(buffer)
        (self.furniture / "box.GLB").write_bytes(glb(*gltf()))
        document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
        (self.root / "inside.gltf").write_text(json.dumps(document))
        masks = {(self.assert_stands(name) / "truth/instances/000000.png").read_bytes()
                 for name in ("chairs/box.obj", "chairs/box.gltf", "box.GLB", "inside.gltf")}
        self.assertEqual(len(masks), 1)

    def test_size_m_brings_any_unit_to_size(self):
        (self.furniture / "millimetres.obj").write_text(obj([tuple(1000 * c for c in p) for p in CORNERS], FACES))
        code, stderr, _ = self.synth(self.chair("millimetres.obj"))
        self.assertEqual(code, 3)
        self.assertIn("size_m", stderr)
        code, stderr, _ = self.synth(self.chair("millimetres.obj") + ", size_m: [0.4, 0.6, 0.8]")
        self.assertEqual(code, 0, stderr)

    def test_same_seed_same_bytes_on_one_core(self):
        (self.furniture / "box.obj").write_text(obj(CORNERS, FACES))
        captures = [self.synth(self.chair("box.obj"), frames=4)[2],
                    self.synth(self.chair("box.obj"), frames=4, before=("taskset", "-c", "0"))[2]]
        files = [{file.relative_to(c): file.read_bytes() for file in c.rglob("*") if file.is_file()} for c in captures]
        self.assertGreater(len(files[0]), 14)
        self.assertEqual(files[0], files[1])

    def test_a_mesh_that_is_no_solid_works(self):
        # Three sheets on one edge, a lone triangle, and a face twice the other way round.
        vertices = [(0, 0, 0), (0, 1, 0), (0.5, 0, 0.1), (-0.5, 0, 0.1), (0, 0, -0.5), (0.2, 0.5, 0.4), (0.3, 0.9, 0.4),
                    (0.4, 0.5, 0.4)]
        faces = [(0, 1, 2), (0, 1, 3), (0, 1, 4), (5, 6, 7), (7, 6, 5)]
        (self.furniture / "sheets.obj").write_text(obj(vertices, faces))
        code, stderr, _ = self.synth(self.chair("sheets.obj"))
        self.assertEqual(code, 0, stderr)

    def test_missing_empty_and_damaged_meshes(self):
        (self.furniture / "chairs/armchair.obj").write_text(obj(CORNERS, FACES))
        self.assert_refused("chairs/armchiar.obj", "scene.yaml:8", "'chairs/armchiar.obj'", "--furniture",
                            "'chairs/armchair.obj'")
        (self.furniture / "empty.obj").write_text("")
        self.assert_refused("empty.obj", "empty.obj", "no faces")
        (self.furniture / "points.obj").write_text(obj(CORNERS, []))
        self.assert_refused("points.obj", "no faces")
        (self.furniture / "beyond.obj").write_text(obj(CORNERS, [(0, 1, 99)]))
        self.assert_refused("beyond.obj", "face 0 names vertex")
        document, buffer = gltf()
        (self.furniture / "nan.glb").write_bytes(glb(document, struct.pack("<f", float("nan")) + buffer[4:]))
        self.assert_refused("nan.glb", "vertex 0 is not finite")
        (self.furniture / "flat.obj").write_text(obj([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]))
        self.assert_refused("flat.obj", "flat")
        document, buffer = gltf("gone.bin")
        (self.furniture / "gone.gltf").write_text(json.dumps(document))
        self.assert_refused("gone.gltf", "gone.gltf", "buffers[0].uri", "gone.bin")
        (self.furniture / "gone.bin").write_bytes(buffer[:40])
        self.assert_refused("gone.gltf", "cut off")
        (self.furniture / "short.glb").write_bytes(glb(*gltf())[:-20])
        self.assert_refused("short.glb", "short.glb", "truncated")
        (self.furniture / "none.glb").write_bytes(b"")
        self.assert_refused("none.glb", "none.glb")
        document, buffer = gltf()
        document["meshes"][0]["primitives"][0]["mode"] = 0
        (self.furniture / "cloud.glb").write_bytes(glb(document, buffer))
        self.assert_refused("cloud.glb", "no triangles")

    def test_huge_meshes_say_why(self):
        (self.furniture / "huge.obj").write_text(obj(CORNERS, []) + "f 1 2 3\n" * 2_000_001)
        self.assert_refused("huge.obj", "2000001 faces", "Decimate")
        document, buffer = gltf()
        document["accessors"][1]["count"] = 4_000_000_000
        (self.furniture / "lies.glb").write_bytes(glb(document, buffer))
        self.assert_refused("lies.glb", "4000000000")

    def test_a_camera_inside_furniture_is_refused_and_one_beyond_a_wall_told(self):
        (self.furniture / "box.obj").write_text(obj(CORNERS, FACES))
        code, stderr, _ = self.synth(self.chair("box.obj"), radius=0.2, height=0.5)
        self.assertEqual(code, 3)
        self.assertIn("camera enters chair 'box.obj' in frame 0", stderr)
        code, stderr, capture = self.synth(self.chair("box.obj"), radius=3)
        self.assertEqual(code, 0)
        self.assertIn("through it, in frame 0", stderr)
        self.assertTrue((capture / "truth/objects.json").exists())

    def test_unknown_names_are_told_with_the_nearest(self):
        (self.furniture / "box.obj").write_text(obj(CORNERS, FACES))
        code, stderr, _ = self.synth(self.chair("box.obj"), preset="kinect_v3")
        self.assertEqual(code, 2)
        for word in ("scene.yaml:4", "camera.preset", "kinect_v3", "did you mean kinect_v"):
            self.assertIn(word, stderr)
        code, stderr, _ = self.synth(self.chair("box.obj") + ", yaw_degs: 3")
        self.assertEqual(code, 2)
        self.assertIn("did you mean yaw_deg?", stderr)
        code, stderr, _ = self.synth(self.chair("box.obj"), more=("--rung", "noise"))
        self.assertEqual(code, 2)
        self.assertIn("'noise'", stderr)
        code, stderr, _ = self.synth(self.chair("box.obj"), more=("--furniture", self.root / "nowhere"))
        self.assertEqual(code, 2)
        self.assertIn("nowhere", stderr)
        code, stderr, _ = self.synth(self.chair("no file"))
        self.assertEqual(code, 3)
        self.assertIn("catalogues", stderr)


if __name__ == "__main__":
    os.environ.setdefault("LC_ALL", "C.UTF-8")
    unittest.main(argv=sys.argv[:1])
