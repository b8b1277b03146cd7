#!/usr/bin/env python3
"""The rooms and the tables of scripts/experiments/one_sided.py.

    one_sided_experiment_test.py REPOSITORY
"""
import math
import pathlib
import re
import sys
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(REPOSITORY / "scripts" / "experiments"))
import one_sided  # noqa: E402
import table1  # noqa: E402

SEEDS = range(12)


def furniture(text):
    pattern = r'class: (\w+), model: "([^"]+)", position_m: \[([-\d.]+), ([-\d.]+)\]'
    return [(kind, model, (float(x), float(y))) for kind, model, x, y in re.findall(pattern, text)]


def way(text):
    return [(float(x), float(y)) for x, y in re.findall(r"\[([-\d.]+), ([-\d.]+), [\d.]+\]", re.search(r"points_m: .*", text)[0])]


class Rooms(unittest.TestCase):
    def test_every_product_is_withheld_and_stands_once(self):
        for seed in SEEDS:
            pieces = furniture(one_sided.scene(seed))
            self.assertEqual(len(pieces), 8)
            self.assertEqual(len({model for _, model, _ in pieces}), 8)
            for kind, model, _ in pieces:
                self.assertIn(model, table1.withheld(kind))

    def test_no_object_is_seen_from_more_than_sixty_degrees(self):
        for seed in SEEDS:
            text = one_sided.scene(seed)
            for _, _, (x, y) in furniture(text):
                angles = [math.degrees(math.atan2(b - y, a - x)) for a, b in way(text)]
                self.assertLess(max(angles) - min(angles), 60)

    def test_a_seed_is_a_room_of_its_own_and_always_the_same(self):
        self.assertEqual(one_sided.scene(5), one_sided.scene(5))
        self.assertNotEqual(one_sided.scene(5), one_sided.scene(6))


def selection(*objects):
    """Of objects (number, final source, {source: (iou, cd, unseen)})."""
    rows = []
    for number, final, sources in objects:
        candidates = [{"candidate": n, "source": source, "iou_peak": iou, "chamfer": cd, "unseen_share": unseen}
                      for n, (source, (iou, cd, unseen)) in enumerate(sources.items())]
        rows.append({"class": "chair", "capture": "c", "true_number": number, "candidates": candidates,
                     "final": list(sources).index(final)})
    return {"objects": rows}


class Tables(unittest.TestCase):
    def test_only_objects_that_both_have_are_compared(self):
        measured = selection((1, "fused", {"retrieval": (0.2, 0.1, 0.1), "fused": (0.3, 0.1, 0.2)}),
                             (2, "fused", {"fused": (0.9, 0.0, 0.9)}))
        networks = selection((1, "network", {"network": (0.5, 0.05, 0.7), "fused": (0.3, 0.1, 0.2)}))
        text = one_sided.report({"measured": measured, "networks": networks})
        self.assertIn("| final, measured | 1 | 0.300 | 0.100 | 20.0 |", text)
        self.assertIn("| final, networks | 1 | 0.500 | 0.050 | 70.0 |", text)
        self.assertIn("| retrieval, measured | 1 | +0.300 [+0.300, +0.300]", text)
        self.assertIn("| chair | 1 | 0.300 | 0.500 | 0.100 | 0.050 | 20.0 | 70.0 |", text)

    def test_intervals_hold_the_mean_and_narrow_with_the_number(self):
        mean, low, high = one_sided.mean_interval([0.0, 1.0] * 10)
        self.assertEqual(mean, 0.5)
        self.assertTrue(low < 0.5 < high)
        _, closer, further = one_sided.mean_interval([0.0, 1.0] * 40)
        self.assertLess(further - closer, high - low)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
