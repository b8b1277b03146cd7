"""Triangle meshes in memory."""
from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .documents import Floats
from .geometry import transform_points

if TYPE_CHECKING:
    import trimesh

Ints = npt.NDArray[np.int64]
Bytes = npt.NDArray[np.uint8]


@dataclasses.dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles over vertices in metres, counter-clockwise seen from outside.

    `normals` have length 1; `colours` are sRGB with opacity, 0 to 255. Both are None where the file has none.
    """

    vertices_m: Floats  # (n, 3)
    faces: Ints  # (m, 3)
    normals: Floats | None = None  # (n, 3)
    colours: Bytes | None = None  # (n, 4)

    @property
    def bounds_m(self) -> Floats:
        """(2, 3): the smallest and the largest coordinates. An empty mesh has none: NaN."""
        if len(self.vertices_m) == 0:
            return np.full((2, 3), np.nan)
        return np.stack([self.vertices_m.min(axis=0), self.vertices_m.max(axis=0)])

    @property
    def area_m2(self) -> float:
        """Of all triangles."""
        a, b, c = np.moveaxis(self.vertices_m[self.faces], 1, 0)
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    @property
    def volume_m3(self) -> float:
        """Of what it encloses; means something where `is_closed`."""
        a, b, c = np.moveaxis(self.vertices_m[self.faces], 1, 0)
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    @property
    def is_closed(self) -> bool:
        """Whether every edge is run through once in each direction, by vertices at one place as by one vertex."""
        if len(self.faces) == 0:
            return False
        _, place = np.unique(self.vertices_m, axis=0, return_inverse=True)
        faces = place.reshape(-1)[self.faces]
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        edges = edges[edges[:, 0] != edges[:, 1]]  # of faces that have shrunk to a line
        keys = edges[:, 0] * len(self.vertices_m) + edges[:, 1]
        back = edges[:, 1] * len(self.vertices_m) + edges[:, 0]
        return bool(len(np.unique(keys)) == len(keys) and np.array_equal(np.sort(keys), np.sort(back)))

    def transformed(self, b_from_a: Floats) -> Mesh:
        """The mesh in frame b; `b_from_a` is rigid."""
        normals = None if self.normals is None else self.normals @ b_from_a[:3, :3].T
        return dataclasses.replace(self, vertices_m=transform_points(b_from_a, self.vertices_m), normals=normals)

    def to_trimesh(self) -> trimesh.Trimesh:
        """As trimesh has it: vertices at one place are one, so that what is closed is watertight; normals are its own.

        Needs the extra: `pip install deepslam[mesh]`.
        """
        import trimesh

        mesh = trimesh.Trimesh(self.vertices_m, self.faces, vertex_colors=self.colours, process=False)
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        return mesh


EMPTY = Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))


def joined(meshes: list[Mesh]) -> Mesh:
    """All of them as one; normals and colours where every one has them."""
    if len(meshes) == 1:
        return meshes[0]
    if not meshes:
        return EMPTY
    offsets = np.cumsum([0, *(len(mesh.vertices_m) for mesh in meshes[:-1])])
    normals = [mesh.normals for mesh in meshes if mesh.normals is not None]
    colours = [mesh.colours for mesh in meshes if mesh.colours is not None]
    return Mesh(
        np.concatenate([mesh.vertices_m for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets)]),
        np.concatenate(normals) if len(normals) == len(meshes) else None,
        np.concatenate(colours) if len(colours) == len(meshes) else None,
    )
