"""Python packages that tests may need: Debian's numpy, and GTSAM where scripts/setup.sh --tests puts it."""
import importlib
import os
import pathlib
import sys

SKIPPED = 77
DEBIANS = "/usr/bin/python3"
CACHE = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "deepslam" / "python"


def need(*names):
    """The modules. Where one is missing the test starts anew in Debian's Python, and is skipped where it is missing there.

    Debian's packages are there for Debian's Python, which need not be the first on the path.
    """
    sys.path += [str(folder) for folder in sorted(CACHE.glob("*-*")) if str(folder) not in sys.path]
    try:
        return [importlib.import_module(name) for name in names]
    except ImportError as fault:
        if pathlib.Path(DEBIANS).exists() and "DEEPSLAM_SECOND_TRY" not in os.environ:
            os.execve(DEBIANS, [DEBIANS, *sys.argv], {**os.environ, "DEEPSLAM_SECOND_TRY": "1"})
        print(f"skipped: {fault}; scripts/setup.sh --tests installs it", file=sys.stderr)
        sys.exit(SKIPPED)
