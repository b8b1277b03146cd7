"""Files that are short, damaged, hostile or of the future: `Error` with file, place, value and remedy, and nothing else."""
from __future__ import annotations

import json
import pathlib
import random
import shutil
import tempfile
import unittest
from collections.abc import Callable
from typing import Any

import deepslam
import handmade


def everything(scene: deepslam.Scene) -> None:
    """Reads all that there is."""
    scene.trajectory, scene.relations, scene.not_mapped, scene.surroundings
    for each in scene.objects:
        each.mesh_world, each.box, each.votes, each.candidates, each.labels


class BadInput(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="deepslam-python-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.workspace = handmade.write(self.folder / "workspace")

    def refused(self, *parts: str) -> deepslam.Error:
        with self.assertRaises(deepslam.Error) as caught:
            everything(deepslam.open(self.workspace))
        for part in parts:
            self.assertIn(part, str(caught.exception))
        self.assertTrue(caught.exception.remedy)
        return caught.exception

    def changed(self, name: str, change: Callable[[Any], object]) -> None:
        file = self.workspace / name
        document = json.loads(file.read_text())
        change(document)
        file.write_text(json.dumps(document))

    def test_each_fault_is_told_with_its_place(self) -> None:
        def set_at(*path: Any) -> Callable[[Any], object]:
            def change(document: Any) -> None:
                for key in path[:-2]:
                    document = document[key]
                document[path[-2]] = path[-1]
            return change

        for name, change, parts in (
            ("export/map.json", set_at("version", 6), ["map.json: version is 6, newer than 5", "install the package"]),
            ("export/map.json", set_at("version", 3), ["version is 3, older than 4"]),
            ("export/map.json", set_at("format", "deepslam/tracks"), ['format is "deepslam/tracks", must be "deepslam/map"']),
            ("export/map.json", set_at("objects", 1, "confidence", 7), ["objects[1].confidence is 7, must be a number in [0, 1]"]),
            ("export/map.json", set_at("objects", 0, "name", None), ['objects[0] has no member "name"']),
            ("export/map.json", set_at("objects", 0, "world_from_object", "rotation_xyzw", [0, 0, 0, 2]),
             ["objects[0].world_from_object.rotation_xyzw has length 2"]),
            ("export/map.json", set_at("objects", 0, "size_m", [1, 2]), ["objects[0].size_m has 2 entries, must have 3"]),
            ("export/map.json", set_at("objects", 0, "room", 4), ["objects[0].room is 4, but the map has 1"]),
            ("export/map.json", set_at("objects", 0, "id", 3), ["objects[1].id is 3, must be above 3"]),
            ("export/map.json", set_at("objects", 0, "id", True), ["objects[0].id is true"]),
            ("export/map.json", set_at("objects", 0, "size_m", [1, 1, 10**400]), ["objects[0].size_m[2]"]),
            ("export/map.json", set_at("verdict", "splendid"), ['verdict is "splendid", must be one of: good, doubtful, bad']),
            ("export/map.json", set_at("layout", "rooms", 0, "polygon_m", [0, 0, 1, 1]), ["layout.rooms[0].polygon_m has 4 numbers"]),
            ("export/map.json", set_at("layout", "openings", 0, "wall", 9), ["layout.openings[0].wall is 9"]),
            ("export/map.json", set_at("layout", "walls", 0, "top_m", -1), ["layout.walls[0].top_m is -1"]),
            ("export/scene_graph.json", set_at("capture_hash", "00"), ["scene_graph.json: is of another run"]),
            ("export/scene_graph.json", set_at("relations", 0, "subject", "sofa_09"), ['relations[0].subject is "sofa_09"']),
            ("export/scene_graph.json", set_at("relations", 0, "predicate", "likes"), ['predicate is "likes", must be one of: in_room']),
            ("optimize/objects.json", set_at("objects", 0, "id", 8), ["has no object 0, which the map has"]),
            ("optimize/objects.json", set_at("objects", 0, "scores", 0, "score", "x"), ['objects[0].scores[0].score is "x", must be a number']),
            ("optimize/frames.json", set_at("frames", []), ["frames has 0 entries, must have 3"]),
            ("optimize/frames.json", set_at("frames", 0, "status", "asleep"), ['frames[0].status is "asleep"']),
            ("optimize/frames.json", set_at("keyframes", [0, 3]), ["keyframes[1] is 3"]),
            ("propose/candidates.json", set_at("version", 1), ["propose/candidates.json: version is 1, older than 2"]),
            ("workspace.json", set_at("version", 2), ["workspace.json: version is 2, newer"]),
        ):
            with self.subTest(name=name, parts=parts):
                before = (self.workspace / name).read_bytes()
                self.changed(name, change)
                self.refused(*parts)
                (self.workspace / name).write_bytes(before)
        everything(deepslam.open(self.workspace))

    def test_texts_that_are_no_json(self) -> None:
        file = self.workspace / "export/map.json"
        whole = file.read_bytes()
        for data in (b"", b"{", whole[:-20], b"[1]", b"null", b"\xff\xfe\x00", b"[" * 100000, b'{"a": NaN}', whole.replace(b"0.75", b"Infinity")):
            with self.subTest(data=data[:20]):
                file.write_bytes(data)
                self.refused("map.json")

    def test_lines_of_the_path(self) -> None:
        file = self.workspace / "optimize/trajectory.tum"
        for text, part in (("0 0 0\n", "line 1 has 3 columns, must have 8"), ("#\n0 0 0 0 0 0 0 x\n", "line 2 is no row of numbers"),
                           ("0 0 0 0 0 0 0 0\n", "line 1 must hold finite"), ("0 nan 0 0 0 0 0 1\n", "line 1 must hold finite")):
            file.write_text(text)
            self.refused("trajectory.tum", part)
        file.write_bytes(b"\xff\xfe")
        self.refused("trajectory.tum", "is no text")

    def test_what_is_missing(self) -> None:
        for name, part in (("optimize/objects.json", "is missing"), ("export/map.json", "the run has not come to stage export"),
                           ("workspace.json", "name a folder that `deepslam run` made")):
            (self.workspace / name).unlink()
            self.refused(name.split("/")[-1], part)
        with self.assertRaisesRegex(deepslam.Error, "nowhere.json: is missing; name a map.json"):
            deepslam.open(self.folder / "nowhere.json")
        other = handmade.write(self.folder / "other")
        shutil.rmtree(other / "optimize")
        with self.assertRaisesRegex(deepslam.Error, "optimize: is missing: the run has not come to this stage"):
            deepslam.open(other).trajectory

    def test_a_damaged_file_never_ends_otherwise(self) -> None:
        """Bytes changed, cut and put in at random: `Error`, or a map that is as sound as the first."""
        chance = random.Random(11)
        for name in ("export/map.json", "export/scene.uncompressed.glb", "export/scene_graph.json", "optimize/objects.json",
                     "optimize/trajectory.tum", "optimize/frames.json"):
            file = self.workspace / name
            whole = file.read_bytes()
            for _ in range(150):
                data = bytearray(whole)
                for _ in range(chance.choice((1, 1, 3))):
                    at = chance.randrange(len(data) or 1)
                    how = chance.randrange(4)
                    if how == 0 and data:
                        data[at % len(data)] = chance.randrange(256)
                    elif how == 1:
                        del data[at:at + chance.choice((1, 5, 400))]
                    elif how == 2:
                        data[at:at] = chance.choice((b"-", b"9", b"e9", b"[", b'"', b"null", bytes(4)))
                    else:
                        data = data[:at + 1]
                file.write_bytes(data)
                try:
                    everything(deepslam.open(self.workspace))
                except deepslam.Error as fault:
                    self.assertTrue(fault.file and fault.problem)
            file.write_bytes(whole)


class Glb(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="deepslam-python-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.workspace = handmade.write(self.folder / "workspace")
        self.file = self.workspace / "export/scene.uncompressed.glb"

    def refused(self, part: str) -> None:
        with self.assertRaises(deepslam.Error) as caught:
            everything(deepslam.open(self.workspace))
        self.assertIn(part, str(caught.exception))

    def test_faults_of_a_scene(self) -> None:
        def write(change: Callable[[dict[str, Any]], object]) -> None:
            writer = handmade.GlbWriter()
            mesh = writer.mesh(handmade.to_gltf(handmade.CORNERS), handmade.BOX_FACES, (1, 2, 3, 4))
            writer.node(name="chair_00", mesh=mesh, extras={"class": "chair"}, **handmade.gltf_place(handmade.CHAIR))
            writer.node(name="table_03", mesh=mesh, extras={"class": "table"}, **handmade.gltf_place(handmade.TABLE))
            change(writer.document)
            self.file.write_bytes(writer.pack())

        for change, part in (
            (lambda d: d["accessors"][0].update(count=9), "accessors[0] goes beyond its buffer"),
            (lambda d: d["accessors"][0].update(count=10**9), "accessors[0].count is 1000000000"),
            (lambda d: d["accessors"][0].update(componentType=7), "componentType is 7"),
            (lambda d: d["accessors"][0].update(type="MAT9"), 'type is "MAT9"'),
            (lambda d: d["accessors"][0].update(sparse={}), "accessors[0].sparse is not read"),
            (lambda d: d["accessors"][1].update(count=7), "COLOR_0 must be 8 vectors"),
            (lambda d: d["accessors"][2].update(count=35), "has 35 corners over 8 vertices"),
            (lambda d: d["accessors"][0].update(count=4), "has 36 corners over 4 vertices"),
            (lambda d: d["bufferViews"][0].update(byteOffset=10**6), "goes beyond its buffer"),
            (lambda d: d["bufferViews"][0].update(byteStride=4), "byteStride is 4"),
            (lambda d: d["bufferViews"][0].update(buffer=1), "bufferViews[0].buffer is 1, but there are 1 buffers"),
            (lambda d: d["nodes"][0].update(mesh=5), "nodes[0].mesh is 5, but there are 1 meshes"),
            (lambda d: d["nodes"][0].update(children=[1]) or d["nodes"][1].update(children=[0]), "is among its own children"),
            (lambda d: d["nodes"][0].update(children=[1, 1]), "nodes[0].children[1] is 1"),
            (lambda d: d["nodes"][0].update(rotation=[0, 0, 0, 9]), "nodes[0].rotation has length 9"),
            (lambda d: d["nodes"][0].update(matrix=[1] * 16), "nodes[0].matrix is not read"),
            (lambda d: d["nodes"][0].update(name="chair_01"), 'has no node "chair_00"'),
            (lambda d: d["nodes"][0].update(translation=[9, 9, 9]), 'node "chair_00" stands elsewhere'),
        ):
            with self.subTest(part=part):
                write(change)
                self.refused(part)
        write(lambda _: None)
        everything(deepslam.open(self.workspace))
        for data, part in ((b"glTF", "is no binary glTF file"), (self.file.read_bytes()[:-4], "must be 2 and its size"),
                           (b"", "is no binary glTF file")):
            self.file.write_bytes(data)
            self.refused(part)

    def test_a_compressed_scene_is_refused_with_the_way_around_it(self) -> None:
        from deepslam.glb import read_glb

        with self.assertRaises(deepslam.Error) as caught:
            read_glb(self.workspace / "export/scene.glb")
        self.assertIn("compressed by Draco", str(caught.exception))
        self.assertIn("--uncompressed", caught.exception.remedy)

    def test_quantised_meshes(self) -> None:
        """Coordinates as normalised 16-bit integers with the scale at the node (KHR_mesh_quantization)."""
        import numpy as np

        writer = handmade.GlbWriter()
        chair = np.round(handmade.to_gltf(handmade.CORNERS) * 2 * 32767).astype("<i2")
        padded = np.zeros((8, 4), "<i2")  # rows of 8 bytes, as alignment asks for
        padded[:, :3] = chair
        mesh = writer.mesh(padded, handmade.BOX_FACES, normalized=True)
        writer.document["bufferViews"][0]["byteStride"] = 8
        sx, sy, sz = handmade.CHAIR_SIZE
        writer.node(name="chair_00", mesh=mesh, extras={"class": "chair"}, scale=[sy / 2, sz / 2, sx / 2], **handmade.gltf_place(handmade.CHAIR))
        writer.node(name="table_03", mesh=mesh, extras={"class": "table"}, **handmade.gltf_place(handmade.TABLE))
        self.file.write_bytes(writer.pack())
        bounds = deepslam.open(self.workspace).object(0).mesh.bounds_m
        np.testing.assert_allclose(bounds[1] - bounds[0], handmade.CHAIR_SIZE, rtol=1e-4)
