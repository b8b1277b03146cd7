"""Python packages that tests may need: Debian's numpy, and what scripts/setup.sh --tests puts beside it.

That is GTSAM, in a folder of its own, and an environment with what scripts/test_requirements.txt lists.
"""
import importlib
import os
import pathlib
import sys

SKIPPED = 77
DEBIANS = "/usr/bin/python3"
TRIED = "DEEPSLAM_PYTHONS_TRIED"
CACHE = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "deepslam" / "python"


ENVIRONMENT = CACHE / "environment" / "bin" / "python3"


def need(*names):
    """The modules. Where one is missing the test starts anew in Debian's Python, then in the environment of the tests, and
    is skipped where it is missing there as well.

    Debian's packages are there for Debian's Python, which need not be the first on the path.
    """
    sys.path += [str(folder) for folder in sorted(CACHE.glob("*-*")) if str(folder) not in sys.path]
    try:
        return [importlib.import_module(name) for name in names]
    except ImportError as fault:
        tried = int(os.environ.get(TRIED, "0"))
        for number, python in enumerate((DEBIANS, ENVIRONMENT), 1):
            if number > tried and pathlib.Path(python).exists():
                os.execve(python, [str(python), *sys.argv], {**os.environ, TRIED: str(number)})
        print(f"skipped: {fault}; scripts/setup.sh --tests installs it", file=sys.stderr)
        sys.exit(SKIPPED)
