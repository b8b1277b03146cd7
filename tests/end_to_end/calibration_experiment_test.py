#!/usr/bin/env python3
"""The table and the figure of scripts/experiments/calibration.py.

    calibration_experiment_test.py REPOSITORY
"""
import math
import pathlib
import sys
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(REPOSITORY / "scripts" / "experiments"))
import calibration  # noqa: E402


class Table(unittest.TestCase):
    def test_every_object_stands_in_one_row_with_the_means_of_its_row(self):
        pairs = [(0.0, False), (0.3, True), (0.36, False), (0.95, True), (1.0, True), (0.9, False)]
        rows = [line.split("|")[1:-1] for line in calibration.table(pairs).splitlines()[2:]]
        rows = {cells[0].strip(): [cell.strip() for cell in cells[1:]] for cells in rows}
        self.assertEqual(sum(int(cells[0]) for cells in rows.values()), len(pairs))
        self.assertEqual(rows["0.0 to 0.3"], ["1", "0.00", "0.00"])
        self.assertEqual(rows["0.3 to 0.6"], ["2", "0.33", "0.50"])
        self.assertEqual(rows["0.6 to 0.8"], ["0", "", ""])
        self.assertEqual(rows["0.9 to 1.0"], ["3", "0.95", "0.67"])


class LogLoss(unittest.TestCase):
    def test_of_what_is_said_rightly_is_less_than_of_the_mean_and_of_the_opposite(self):
        right = [True, True, True, False]
        said = calibration.log_loss(list(zip([0.9, 0.9, 0.9, 0.2], right)))
        mean = calibration.log_loss([(0.75, one) for one in right])
        opposite = calibration.log_loss(list(zip([0.1, 0.1, 0.1, 0.8], right)))
        self.assertLess(said, mean)
        self.assertLess(mean, opposite)
        self.assertAlmostEqual(mean, -(3 * math.log(0.75) + math.log(0.25)) / 4)

    def test_one_that_is_sure_and_wrong_stays_finite(self):
        self.assertTrue(math.isfinite(calibration.log_loss([(1.0, False), (0.0, True)])))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
