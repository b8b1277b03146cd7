"""Transforms and boxes. `b_from_a` is a 4x4 matrix: x_b = b_from_a @ x_a, for columns x = (x, y, z, 1)."""
from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from .documents import Floats, Node

# Metres; farther than any place of a map.
_FAR_M = 1e6


def pose_matrix(rotation_xyzw: npt.ArrayLike, translation_m: npt.ArrayLike) -> Floats:
    """4x4 matrix of a rotation (unit quaternion x, y, z, w) and a translation; of stacks of them too: (n, 4) and (n, 3)."""
    q = np.asarray(rotation_xyzw, dtype=np.float64)
    t = np.asarray(translation_m, dtype=np.float64)
    x, y, z, w = np.moveaxis(q, -1, 0)
    matrix = np.zeros((*q.shape[:-1], 4, 4))
    matrix[..., 0, 0] = 1 - 2 * (y * y + z * z)
    matrix[..., 0, 1] = 2 * (x * y - z * w)
    matrix[..., 0, 2] = 2 * (x * z + y * w)
    matrix[..., 1, 0] = 2 * (x * y + z * w)
    matrix[..., 1, 1] = 1 - 2 * (x * x + z * z)
    matrix[..., 1, 2] = 2 * (y * z - x * w)
    matrix[..., 2, 0] = 2 * (x * z - y * w)
    matrix[..., 2, 1] = 2 * (y * z + x * w)
    matrix[..., 2, 2] = 1 - 2 * (x * x + y * y)
    matrix[..., :3, 3] = t
    matrix[..., 3, 3] = 1
    return matrix


def transform_points(b_from_a: Floats, points_a: npt.ArrayLike) -> Floats:
    """(n, 3) points of frame a as points of frame b."""
    result: Floats = np.asarray(points_a, dtype=np.float64) @ b_from_a[:3, :3].T + b_from_a[:3, 3]
    return result


def read_pose(node: Node) -> Floats:
    """The 4x4 matrix of {rotation_xyzw, translation_m}."""
    return pose_matrix(node["rotation_xyzw"].quaternion(), node["translation_m"].numbers(3, -_FAR_M, _FAR_M))


@dataclasses.dataclass(frozen=True, eq=False)
class OrientedBox:
    """A box in the world: its middle and axes by `world_from_box` (4x4), its extent along them by `size_m`."""

    world_from_box: Floats  # (4, 4)
    size_m: Floats  # (3,)

    @property
    def centre_m(self) -> Floats:
        """Its middle in the world."""
        centre: Floats = self.world_from_box[:3, 3].copy()
        return centre

    @property
    def corners_m(self) -> Floats:
        """(8, 3) in the world; bit 0 of the row's number chooses along x, bit 1 along y, bit 2 along z."""
        signs = np.array([[(n >> axis) & 1 for axis in range(3)] for n in range(8)], dtype=np.float64) - 0.5
        return transform_points(self.world_from_box, signs * self.size_m)

    @property
    def volume_m3(self) -> float:
        """Of the box."""
        return float(np.prod(self.size_m))

    def contains(self, points_m: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which of the (n, 3) points of the world lie in it."""
        box_from_world = np.linalg.inv(self.world_from_box).astype(np.float64)
        in_box = transform_points(box_from_world, points_m)
        inside: npt.NDArray[np.bool_] = np.all(np.abs(in_box) <= self.size_m / 2, axis=1)
        return inside
