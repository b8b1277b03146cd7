"""A batch of two captures by the real program, made once for all tests that look at one."""
from __future__ import annotations

import atexit
import functools
import importlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import deepslam

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "end_to_end"))
DATA = pathlib.Path(os.environ.get("XDG_DATA_HOME") or pathlib.Path.home() / ".local/share") / "deepslam"


@functools.cache
def capture() -> pathlib.Path:
    """A table and two chairs in ten frames; the test is skipped where that cannot be made."""
    if not os.environ.get("DEEPSLAM"):
        raise unittest.SkipTest("no program was given (--program)")
    if not (DATA / "library/library.json").is_file() or not (DATA / "weights/yolov8s.onnx").is_file():
        raise unittest.SkipTest("needs weights and furniture library: scripts/setup.sh, scripts/furniture.sh")
    captures = importlib.import_module("captures")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="deepslam-python-"))
    atexit.register(shutil.rmtree, folder, True)
    made: pathlib.Path | None = captures.make_room(os.environ["DEEPSLAM"], folder / "capture")
    if made is None:
        raise unittest.SkipTest("sweethome3d-furniture is not installed")
    return made


@functools.cache
def batch() -> pathlib.Path:
    """The folder of `deepslam batch` with two good captures and one that fails."""
    folder = capture().parent
    shutil.copytree(capture(), folder / "broken")
    (folder / "broken/depth.txt").unlink()
    for file in (folder / "broken").glob("associations.txt"):
        file.unlink()
    (folder / "list.txt").write_text("capture kitchen\ncapture office\nbroken\n")
    result = subprocess.run([deepslam.find_program(), "batch", folder / "list.txt", "-o", folder / "rooms_out", "--progress", "none"],
                            capture_output=True, text=True, timeout=600)
    assert result.returncode == 1, result.stderr
    return folder / "rooms_out"
