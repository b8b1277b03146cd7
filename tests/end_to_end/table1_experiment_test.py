#!/usr/bin/env python3
"""The rooms and the figure of scripts/experiments/table1.py.

    table1_experiment_test.py REPOSITORY
"""
import itertools
import math
import pathlib
import re
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(REPOSITORY / "scripts" / "experiments"))
import table1  # noqa: E402


def furniture(text):
    pattern = r'class: (\w+), model: "([^"]+)", position_m: \[([-\d.]+), ([-\d.]+)\]'
    return [(kind, model, (float(x), float(y))) for kind, model, x, y in re.findall(pattern, text)]


class Rooms(unittest.TestCase):
    def test_every_product_is_withheld_and_its_class_has_networks(self):
        for seed in range(4):
            for kind, model, _ in furniture(table1.scene(seed)):
                self.assertIn(model, table1.withheld(kind))
                self.assertTrue((REPOSITORY / "configs/priors" / kind / "encoder.onnx").exists())

    def test_three_seeds_hold_more_than_forty_pieces_and_leave_room_between_them_and_the_camera(self):
        rooms = [furniture(table1.scene(seed)) for seed in range(3)]
        self.assertGreaterEqual(sum(map(len, rooms)), 40)
        for room in rooms:
            for (_, _, a), (_, _, b) in itertools.combinations(room, 2):
                self.assertGreater(math.dist(a, b), 0.8)
            for _, _, place in room:
                self.assertLess(math.hypot(*place), table1.REACH_M - 1.2)

    def test_a_seed_is_a_room_of_its_own_and_always_the_same(self):
        self.assertEqual(table1.scene(5), table1.scene(5))
        self.assertNotEqual(table1.scene(5), table1.scene(6))


class WayClosed(unittest.TestCase):
    def test_is_the_share_of_the_way_from_the_initial_to_the_oracle(self):
        rows = [{"row": "initial", "iou": 0.2}, {"row": "selected", "iou": 0.35}, {"row": "oracle", "iou": 0.4}]
        self.assertAlmostEqual(table1.way_closed({"rows": rows}, "selected"), 0.75)
        self.assertTrue(math.isnan(table1.way_closed({"rows": [dict(row, iou=0.2) for row in rows]}, "selected")))


class Page(unittest.TestCase):
    SELECTION = {"rows": [{"row": name, "num_objects": 7, "iou": iou, "iou_minus_initial": dict(mean=iou - 0.2, low=0, high=0.5),
                           "chamfer": 0.1, "chamfer_minus_initial": dict(mean=-0.01, low=-0.02, high=0.01)}
                          for name, iou in (("initial", 0.2), ("fused only", 0.9), ("with refinement", 0.456))]}
    OBJECTS = {"summary": {"num_true": 8, "num_mapped": 9, "num_placed": 6}, "classes": [{"num_found": 5}, {"num_found": 2}]}

    def setUp(self):
        self.page = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "page.md"

    def test_only_the_part_between_the_lines_changes(self):
        part = table1.page_part({"all": (self.SELECTION, self.OBJECTS)}, "the command", "abc12345")
        for _ in range(2):
            self.page.write_text(f"before\n{table1.BEGIN}old\n{table1.END}after\n")
            table1.write_page(self.page, part)
            self.assertEqual(self.page.read_text(), f"before\n{table1.BEGIN}{part}{table1.END}after\n")
        self.assertIn("`the command`, commit abc12345", part)
        self.assertRegex(part, r"with refinement \| 7 \| 0\.456 \| \+0\.256 \[0\.000, 0\.500\] \| 0\.100 \| -0\.010")
        self.assertRegex(part, r"\| 8 \| 7 \| 9 \| 6 \|")
        self.assertNotIn("fused", part)

    def test_a_document_without_the_lines_is_left_alone(self):
        for text in ("nothing", table1.END + table1.BEGIN, 2 * (table1.BEGIN + table1.END)):
            self.page.write_text(text)
            with self.assertRaises(SystemExit) as ended:
                table1.write_page(self.page, "part")
            self.assertIn("table1 -->", str(ended.exception))
            self.assertEqual(self.page.read_text(), text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
