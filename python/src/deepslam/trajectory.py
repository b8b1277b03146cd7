"""The camera path in the map's world."""
from __future__ import annotations

import dataclasses
import math
import pathlib

import numpy as np
import numpy.typing as npt

from .documents import MAKE_ANEW, Floats, read_bytes, read_document
from .errors import Error
from .geometry import pose_matrix

_COLUMNS = "time tx ty tz qx qy qz qw"
STATUSES = ("tracked", "degenerate", "lost", "unreadable")


@dataclasses.dataclass(frozen=True, eq=False)
class Trajectory:
    """A pose for every frame of the capture, in order.

    Camera: x right, y down, z forward. `status` says of every frame how its pose came about: `tracked`, `degenerate` (weakly
    constrained in a direction at least), or a prediction alone, where tracking was `lost` or images were `unreadable`.
    """

    times_s: Floats  # (n,): as in the capture
    world_from_camera: Floats  # (n, 4, 4)
    status: tuple[str, ...]  # of every frame
    keyframes: npt.NDArray[np.int64]  # numbers of frames

    def __len__(self) -> int:
        return len(self.times_s)

    @property
    def positions_m(self) -> Floats:
        """(n, 3): where the camera was."""
        return self.world_from_camera[:, :3, 3]

    @property
    def length_m(self) -> float:
        """Of the way from frame to frame."""
        return float(np.linalg.norm(np.diff(self.positions_m, axis=0), axis=1).sum())


def read_trajectory(folder: pathlib.Path) -> Trajectory:
    """Stage `optimize`'s trajectory.tum and frames.json."""
    times_s, poses = read_tum(folder / "trajectory.tum")
    root = read_document(folder / "frames.json", "deepslam/frames", 1)
    rows = root["frames"].items(len(times_s))
    status = tuple(row["status"].choice(STATUSES) for row in rows)
    keyframes = np.array([row.integer(0, len(rows) - 1) for row in root["keyframes"].items()], dtype=np.int64)
    return Trajectory(times_s, poses, status, keyframes)


def read_tum(file: pathlib.Path) -> tuple[Floats, Floats]:
    """Times (n,) and poses (n, 4, 4) of a text in TUM's format."""
    try:
        text = read_bytes(file, MAKE_ANEW).decode("utf-8")
    except UnicodeDecodeError as fault:
        raise Error(file, "", f"is no text: {fault}", MAKE_ANEW) from None
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if len(words) != 8:
            raise Error(file, f"line {number}", f"has {len(words)} columns, must have 8 ({_COLUMNS})", MAKE_ANEW)
        try:
            row = [float(word) for word in words]
        except ValueError as fault:
            raise Error(file, f"line {number}", f"is no row of numbers: {fault}", MAKE_ANEW) from None
        norm = math.hypot(*row[4:])
        if not all(map(math.isfinite, row)) or abs(norm - 1) > 0.01:  # more than a percent off is no rotation
            raise Error(file, f"line {number}", "must hold finite numbers and a quaternion of length 1", MAKE_ANEW)
        rows.append([*row[:4], *(value / norm for value in row[4:])])
    table = np.array(rows, dtype=np.float64).reshape(-1, 8)
    return table[:, 0], pose_matrix(table[:, 4:], table[:, 1:4])
