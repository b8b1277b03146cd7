"""What is opened says what was written; relations between numbers that two files have."""
from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import pathlib
import shutil
import tempfile
import unittest

import numpy as np

import deepslam
import deepslam.check
import handmade
from deepslam.geometry import pose_matrix


class Handmade(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="deepslam-python-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.workspace = handmade.write(self.folder / "workspace")

    def test_objects_are_those_of_the_map(self) -> None:
        scene = deepslam.open(self.workspace)
        self.assertEqual([(each.id, each.name, each.class_name) for each in scene.objects],
                         [(0, "chair_00", "chair"), (3, "table_03", "table")])
        self.assertEqual((scene.verdict, scene.reasons, scene.capture_name), ("doubtful", ("made by hand",), "by hand"))
        chair, table = scene.objects
        self.assertIs(scene.object("table_03"), table)
        self.assertIs(scene.object(0), chair)
        # Its front, x of its own, points along y of the world.
        np.testing.assert_allclose(chair.world_from_object[:3, :3] @ [1, 0, 0], [0, 1, 0], atol=1e-12)
        np.testing.assert_allclose(chair.world_from_object[:3, 3], [1, 2, 0.5])
        self.assertEqual((chair.room, chair.stands_on, chair.against_wall), (0, "floor", 0))
        self.assertEqual((table.room, table.stands_on, table.against_wall), (None, None, None))

    def test_meshes_stand_where_boxes_do(self) -> None:
        scene = deepslam.open(self.workspace)
        for each, volume in zip(scene.objects, (0.24, 0.896)):
            mesh = each.mesh
            np.testing.assert_allclose(mesh.bounds_m[1] - mesh.bounds_m[0], each.size_m, atol=1e-6)
            self.assertAlmostEqual(mesh.volume_m3, volume, places=5)
            self.assertTrue(mesh.is_closed)
            corners = np.sort(each.mesh_world.vertices_m, axis=0)
            np.testing.assert_allclose(corners, np.sort(each.box.corners_m, axis=0), atol=1e-6)
            self.assertTrue(each.box.contains(each.mesh_world.vertices_m * 0.999 + each.box.centre_m * 0.001).all())
            self.assertFalse(each.box.contains([each.box.centre_m + 2 * each.size_m.max()]).any())
        colours = scene.object("chair_00").mesh.colours
        assert colours is not None
        # Half of the linear intensity is 188 of sRGB.
        np.testing.assert_array_equal(np.unique(colours, axis=0), [[255, 0, 188, 255]])
        self.assertIsNone(scene.object("table_03").mesh.colours)
        self.assertEqual(list(scene.surroundings), ["ground"])
        self.assertAlmostEqual(scene.surroundings["ground"].area_m2, 2)

    def test_layout(self) -> None:
        layout = deepslam.open(self.workspace).layout
        assert layout is not None
        self.assertAlmostEqual(layout.rooms[0].area_m2, 24)
        self.assertIsNone(layout.rooms[0].ceiling_m)
        wall, door = layout.walls[0], layout.openings[0]
        self.assertEqual((wall.length_m, door.length_m, door.kind, door.wall), (4, 1, "door", 0))
        np.testing.assert_allclose(wall.corners_m, np.array([[3, -2, 0], [3, 2, 0], [3, 2, 2.5], [3, -2, 2.5]]))

    def test_trajectory(self) -> None:
        path = deepslam.open(self.workspace).trajectory
        self.assertEqual(len(path), 3)
        self.assertEqual(path.status, ("tracked", "lost", "tracked"))
        self.assertEqual(path.keyframes.tolist(), [0, 2])
        self.assertAlmostEqual(path.length_m, 0.7)
        # The last is turned by half a turn about z.
        np.testing.assert_allclose(path.world_from_camera[2] @ [1, 0, 0, 1], [-0.7, 0.4, 1.5, 1], atol=1e-12)

    def test_candidates_votes_and_what_is_not_mapped(self) -> None:
        scene = deepslam.open(self.workspace)
        chair = scene.object("chair_00")
        self.assertEqual([(each.id, each.chosen, each.score) for each in chair.candidates], [(1, True, 0.9), (0, False, 0.6)])
        self.assertEqual([each.proposal.library_id for each in chair.candidates if each.proposal], ["catalogue/1", "catalogue/0"])
        self.assertEqual(chair.votes, {"chair": 3.5, "couch": 0.25})
        self.assertEqual(chair.frames, (0, 2))
        self.assertEqual(scene.not_mapped, ("tv seen in 3 frames: flush in a wall, as a picture is", "object 7: no candidate could be placed"))

    def test_relations_and_labels(self) -> None:
        scene = deepslam.open(self.workspace)
        self.assertEqual([(each.predicate, each.object, each.distance_m) for each in scene.object(0).relations],
                         [("in_room", "room_00", None), ("next_to", "table_03", 0.4)])
        self.assertEqual([each.subject for each in scene.object(3).relations], ["chair_00"])
        self.assertEqual(scene.object(0).labels["coco"], deepslam.Label(56, "chair"))
        self.assertEqual(scene.object(3).labels, {})

    def test_a_map_in_its_workspace_knows_it_and_one_alone_does_not(self) -> None:
        inside = deepslam.open(self.workspace / "export" / "map.json")
        self.assertEqual(inside.workspace, self.workspace)
        self.assertEqual(len(inside.trajectory), 3)
        alone = self.folder / "map.json"
        shutil.copy(self.workspace / "export" / "map.json", alone)
        scene = deepslam.open(alone)
        self.assertEqual(len(scene.objects), 2)
        self.assertEqual(len(deepslam.open(self.folder).objects), 2)
        with self.assertRaisesRegex(deepslam.Error, "open its workspace"):
            scene.trajectory
        with self.assertRaisesRegex(deepslam.Error, "scene_graph.json: is missing; run `deepslam run`"):
            scene.relations
        np.testing.assert_allclose(scene.object(0).box.centre_m, [1, 2, 0.5])  # without the scene graph, the map's own

    def test_a_map_before_layouts(self) -> None:
        document = handmade.compact_map()
        document.update(version=4)
        del document["layout"], document["objects"][0]["room"], document["objects"][0]["against_wall"]
        (self.workspace / "export/map.json").write_text(json.dumps(document))
        self.assertIsNone(deepslam.open(self.workspace).layout)

    def test_dropped_stages_are_said(self) -> None:
        for stage in ("propose", "associate"):
            shutil.rmtree(self.workspace / stage)
            (self.workspace / stage).mkdir()
            (self.workspace / stage / "dropped.json").write_text('{"format": "deepslam/dropped", "version": 1}')
        scene = deepslam.open(self.workspace)
        self.assertEqual([each.proposal for each in scene.object(0).candidates], [None, None])
        with self.assertRaisesRegex(deepslam.Error, "were dropped .*--force associate"):
            scene.not_mapped

    def test_a_recording_takes_any_name(self) -> None:
        if importlib.util.find_spec("rerun") is None:
            self.skipTest("rerun-sdk is not installed")
        document = handmade.compact_map()
        document["objects"][0].update({"name": "Stühle/椅子 [0]", "class": "Stühle/椅子"})
        (self.workspace / "export/map.json").write_text(json.dumps(document))
        (self.workspace / "export/scene_graph.json").unlink()
        file = self.workspace / "export/scene.uncompressed.glb"
        file.write_bytes(handmade.scene_glb(chair="Stühle/椅子 [0]"))
        deepslam.open(self.workspace).to_rerun(self.folder / "scene.rrd")
        from rerun.chunk import RrdReader

        paths = {str(chunk.entity_path) for chunk in RrdReader(self.folder / "scene.rrd").stream()}
        self.assertEqual(len([path for path in paths if "椅子" in path]), 2, paths)

    def test_checking(self) -> None:
        for path, words in ((self.workspace, "2 objects, doubtful, 2 relations, 24 faces, 1 parts around them, 3 poses, 3 candidates"),
                            (self.workspace / "export/scene_graph.json", "2 objects, 2 relations")):
            with contextlib.redirect_stdout(io.StringIO()) as told:
                self.assertEqual(deepslam.check.main([str(path)]), 0)
            self.assertEqual(told.getvalue(), f"{path}: {words}\n")
        (self.workspace / "optimize/trajectory.tum").write_text("x")
        with contextlib.redirect_stderr(io.StringIO()) as fault:
            self.assertEqual(deepslam.check.main([str(self.workspace)]), 3)
        self.assertRegex(fault.getvalue(), "^error: .*trajectory.tum: line 1 has 1 columns")

    def test_an_empty_map(self) -> None:
        document = {**handmade.compact_map(), "objects": [], "layout": {"rooms": [], "walls": [], "openings": []}, "ground_outline_m": []}
        (self.workspace / "export/map.json").write_text(json.dumps(document))
        writer = handmade.GlbWriter()
        (self.workspace / "export/scene.uncompressed.glb").write_bytes(writer.pack())
        scene = deepslam.open(self.workspace)
        self.assertEqual((scene.objects, dict(scene.meshes), dict(scene.surroundings)), ((), {}, {}))
        self.assertEqual(scene.ground_outline_m.shape, (0, 2))


class Meshes(unittest.TestCase):
    def test_volume_and_area_do_not_change_with_the_pose(self) -> None:
        random = np.random.default_rng(5)
        box = deepslam.Mesh(handmade.CORNERS * [0.3, 0.5, 0.7], handmade.BOX_FACES)
        for _ in range(20):
            rotation = random.normal(size=4)
            moved = box.transformed(pose_matrix(rotation / np.linalg.norm(rotation), random.normal(size=3)))
            self.assertAlmostEqual(moved.volume_m3, 0.3 * 0.5 * 0.7)
            self.assertAlmostEqual(moved.area_m2, 2 * (0.15 + 0.21 + 0.35))
            self.assertTrue(moved.is_closed)

    def test_open_and_turned_meshes_are_not_closed(self) -> None:
        faces = handmade.BOX_FACES
        self.assertFalse(deepslam.Mesh(handmade.CORNERS, faces[1:]).is_closed)
        self.assertFalse(deepslam.Mesh(handmade.CORNERS, np.concatenate([faces[:1, ::-1], faces[1:]])).is_closed)
        # Vertices of their own for every face lie at one place with those of the next.
        self.assertTrue(deepslam.Mesh(handmade.CORNERS[faces.reshape(-1)], np.arange(36).reshape(-1, 3)).is_closed)

    def test_trimesh_has_the_same(self) -> None:
        if importlib.util.find_spec("trimesh") is None:
            self.skipTest("trimesh is not installed")
        box = deepslam.Mesh(handmade.CORNERS, handmade.BOX_FACES, colours=np.tile(np.array([9, 8, 7, 255], np.uint8), (8, 1)))
        other = box.to_trimesh()
        self.assertTrue(other.is_watertight)
        self.assertAlmostEqual(float(other.volume), box.volume_m3)
        np.testing.assert_array_equal(getattr(other.visual, "vertex_colors"), box.colours)
        # As glTF has it where colours or normals differ: vertices of their own for every face.
        apart = deepslam.Mesh(box.vertices_m[box.faces.reshape(-1)], np.arange(36).reshape(-1, 3)).to_trimesh()
        self.assertTrue(apart.is_watertight)
        self.assertAlmostEqual(float(apart.volume), box.volume_m3)
