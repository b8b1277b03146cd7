#!/usr/bin/env python3
"""Tests of the Python package: `run.py [--program DEEPSLAM] [--plain] [names of unittest ...]`.

--program is what was built, for the tests that run it; they are skipped without it. --plain: with Debian's Python and its
numpy alone, the oldest that is supported; else with what scripts/test_requirements.txt lists, all extras among it.
"""
import argparse
import os
import pathlib
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "tests" / "support"))
import python_packages  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", help="the deepslam that was built")
    parser.add_argument("--plain", action="store_true", help="numpy alone")
    parser.add_argument("names", nargs="*", help="tests; default: all")
    arguments = parser.parse_args()
    python_packages.need("numpy") if arguments.plain else python_packages.need("numpy", "mypy", "trimesh")
    if arguments.program:
        os.environ["DEEPSLAM"] = str(pathlib.Path(arguments.program).resolve())
    sys.path[:0] = [str(HERE), str(HERE.parent / "src")]
    loader = unittest.TestLoader()
    tests = loader.loadTestsFromNames(arguments.names) if arguments.names else loader.discover(str(HERE))
    result = unittest.TextTestRunner(verbosity=2).run(tests)
    sys.exit(0 if result.wasSuccessful() and result.testsRun else 1)


main()
