"""What the real program writes is read whole, and its files agree with each other."""
from __future__ import annotations

import csv
import importlib.util
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
from typing import Any

import numpy as np

import deepslam
import rooms

EXAMPLE = pathlib.Path(__file__).resolve().parents[1] / "examples" / "batch_plot.py"


class Real(unittest.TestCase):
    scene: deepslam.Scene

    @classmethod
    def setUpClass(cls) -> None:
        cls.scene = deepslam.open(rooms.batch() / "kitchen")

    def test_objects_agree_with_the_list(self) -> None:
        assert self.scene.workspace
        rows = list(csv.DictReader((self.scene.workspace / "export/objects.csv").open(newline="")))
        self.assertGreater(len(rows), 0)
        self.assertEqual([each.name for each in self.scene.objects], [row["name"] for row in rows])
        for each, row in zip(self.scene.objects, rows):
            self.assertEqual(each.class_name, row["class"])
            np.testing.assert_allclose(each.size_m, [float(row[key]) for key in ("depth_m", "width_m", "height_m")], atol=6e-4)
            front = each.world_from_object[:3, 0]
            turned = np.degrees(np.arctan2(front[1], front[0])) - float(row["heading_deg"])
            self.assertLess(abs((turned + 180) % 360 - 180), 0.1)
            # The list rounds to a tenth of a litre.
            self.assertAlmostEqual(each.mesh.volume_m3, float(row["volume_m3"]), delta=2e-4)

    def test_meshes_are_closed_and_as_large_as_the_map_says(self) -> None:
        for each in self.scene.objects:
            self.assertTrue(each.mesh.is_closed, each)
            bounds = each.mesh.bounds_m
            np.testing.assert_allclose(bounds[1] - bounds[0], each.size_m, atol=1e-3)
            self.assertTrue((each.mesh_world.bounds_m[0, 2] > -0.1).all(), "nothing goes into the floor")
            self.assertIsNotNone(each.mesh.colours)
            if importlib.util.find_spec("trimesh") is not None:
                other = each.mesh.to_trimesh()
                self.assertTrue(other.is_watertight, each)
                self.assertAlmostEqual(float(other.volume), each.mesh.volume_m3)

    def test_expanded_meshes_are_those_of_the_scene(self) -> None:
        expanded = self.scene.expand(data=rooms.DATA)
        self.assertEqual(set(expanded), set(self.scene.meshes))
        for name, mesh in expanded.items():
            np.testing.assert_allclose(mesh.bounds_m, self.scene.meshes[name].bounds_m, atol=2e-3)
            self.assertAlmostEqual(mesh.volume_m3 / self.scene.meshes[name].volume_m3, 1, delta=0.02)

    def test_path_candidates_votes_and_surroundings(self) -> None:
        self.assertEqual(len(self.scene.trajectory), 10)
        self.assertGreater(self.scene.trajectory.length_m, 0.3)
        for each in self.scene.objects:
            scores = [candidate.score for candidate in each.candidates]
            self.assertEqual([candidate.proposal is None for candidate in each.candidates], [False] * len(scores))
            self.assertEqual(sum(candidate.chosen for candidate in each.candidates), 1)
            self.assertGreater(max(each.votes.values()), 0)
            self.assertTrue(set(each.frames) <= set(range(10)))
        self.assertIn("ground", self.scene.surroundings)
        self.assertIsInstance(self.scene.not_mapped, tuple)

    def test_relations_and_boxes_of_the_scene_graph(self) -> None:
        for each in self.scene.objects:
            np.testing.assert_allclose(np.sort(each.box.corners_m, axis=0).mean(axis=0), each.box.centre_m, atol=1e-9)
            box_from_world = np.linalg.inv(each.box.world_from_box)
            in_box = each.mesh_world.vertices_m @ box_from_world[:3, :3].T + box_from_world[:3, 3]
            np.testing.assert_allclose(np.abs(in_box).max(axis=0), each.box.size_m / 2, atol=2e-3)
        names = {each.name for each in self.scene.objects}
        self.assertTrue(all(relation.subject in names for relation in self.scene.relations))
        self.assertEqual([each.name for each in self.scene.objects if each.class_name == "chair" and "coco" not in each.labels], [])

    def test_a_batch(self) -> None:
        batch = deepslam.open_batch(rooms.batch())
        self.assertEqual([(each.name, each.state) for each in batch.captures], [("kitchen", "done"), ("office", "done"), ("broken", "failed")])
        self.assertEqual([each.exit_code for each in batch.captures], [0, 0, 3])
        self.assertTrue(batch.captures[2].reason)
        for each in batch.done:
            self.assertEqual(sum(each.objects.values()), len(each.open().objects))
            self.assertEqual(each.verdict, each.open().verdict)

    def test_a_run_by_the_program(self) -> None:
        with tempfile.TemporaryDirectory(prefix="deepslam-python-") as name:
            events: list[deepslam.Progress] = []
            bare: dict[str, object] = {"detect.source": "none", "propose.retrieval": False}
            result = deepslam.run(rooms.capture(), pathlib.Path(name) / "workspace", bare, on_progress=events.append)
            self.assertEqual(list(result.ran), [event.stage for event in events if event.event == "done"])
            assert result.map_json and result.scene_glb and result.report_html
            self.assertTrue(all(file.is_file() for file in (result.map_json, result.scene_glb, result.report_html)))
            self.assertEqual(deepslam.open(result.workspace).capture_name, "capture")
            again = deepslam.run(rooms.capture(), result.workspace, bare)
            self.assertEqual((again.ran, set(again.skipped)), ((), set(result.ran)))
            with self.assertRaisesRegex(deepslam.UsageError, "no.such.option"):
                deepslam.run(rooms.capture(), result.workspace, {"no.such.option": 1})
            with self.assertRaises(deepslam.InputUnusable):
                deepslam.run(pathlib.Path(name) / "nowhere", result.workspace)

    def test_the_example_draws_the_batch(self) -> None:
        if importlib.util.find_spec("matplotlib") is None:
            self.skipTest("matplotlib is not installed")
        with tempfile.TemporaryDirectory(prefix="deepslam-python-") as name:
            picture = pathlib.Path(name) / "batch.png"
            source = pathlib.Path(deepslam.__file__).parents[1]
            result = subprocess.run([sys.executable, EXAMPLE, rooms.batch(), picture], capture_output=True, text=True, timeout=300,
                                    env={"PYTHONPATH": str(source), "MPLCONFIGDIR": name})
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("broken: failed", result.stdout)
            import matplotlib.image

            pixels = matplotlib.image.imread(picture)
            # Both plans have the colours of tables and chairs, which are drawn over a floor that is nearly white.
            colourful = (pixels[..., :3].max(axis=2) - pixels[..., :3].min(axis=2)) > 0.2
            lower = colourful[colourful.shape[0] // 2:]
            for third in range(2):
                width = lower.shape[1] // 3
                self.assertGreater(int(lower[:, third * width:(third + 1) * width].sum()), 500)

    def test_a_recording(self) -> None:
        if importlib.util.find_spec("rerun") is None:
            self.skipTest("rerun-sdk is not installed")
        from rerun.chunk import RrdReader

        with tempfile.TemporaryDirectory(prefix="deepslam-python-") as name:
            file = pathlib.Path(name) / "kitchen.rrd"
            self.scene.to_rerun(file)
            chunks: list[Any] = list(RrdReader(file).stream())
            paths = {str(chunk.entity_path).strip("/") for chunk in chunks}
            for each in self.scene.objects:
                self.assertLessEqual({f"objects/{each.name}/box", f"objects/{each.name}/mesh"}, paths)
            self.assertIn("room/ground", paths)
            poses = [chunk.to_record_batch() for chunk in chunks if str(chunk.entity_path).strip("/") == "camera/now"]
            turns = [batch.column(name).to_pylist() for batch in poses for name in batch.schema.names if "mat3x3" in name]
            self.assertEqual(len(turns[-1]), 10)
            columns = np.array(turns[-1][-1][0]).reshape(3, 3)
            np.testing.assert_allclose(columns.T, self.scene.trajectory.world_from_camera[-1, :3, :3], atol=1e-6)
            with self.assertRaisesRegex(deepslam.Error, "cannot be written"):
                self.scene.to_rerun(pathlib.Path(name) / "no folder" / "kitchen.rrd")


class Documents(unittest.TestCase):
    def test_a_batch_by_hand(self) -> None:
        with tempfile.TemporaryDirectory(prefix="deepslam-python-") as name:
            row = {"name": "../x", "capture": "c", "state": "done", "reason": "", "exit_code": 0, "verdict": "good", "verdict_reasons": [],
                   "objects": {}, "wall_s": 1}
            file = pathlib.Path(name) / "batch.json"
            for change, part in ((row, 'captures[0].name is "../x", must be the name of a folder'),
                                 ({**row, "name": "x", "state": "?"}, 'captures[0].state is "?"')):
                file.write_text(json.dumps({"format": "deepslam/batch", "version": 1, "tool_version": "", "state": "", "captures": [change]}))
                with self.assertRaises(deepslam.Error) as caught:
                    deepslam.open_batch(name)
                self.assertIn(part, str(caught.exception))
