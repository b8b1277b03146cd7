#!/usr/bin/env python3
"""The rooms and the figure of scripts/experiments/table1.py.

    table1_experiment_test.py REPOSITORY
"""
import itertools
import math
import pathlib
import re
import sys
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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
