"""Meshes of the scenes that deepslam writes (.glb), with numpy alone.

Binary glTF 2.0 with its data in one piece. Draco and meshopt are not decoded: a file that needs them is refused, with what
to do instead. glTF is y up; everything given here is z up, as the map is.
"""
from __future__ import annotations

import dataclasses
import json
import pathlib
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from .documents import MAKE_ANEW, Floats, Node, read_bytes
from .errors import Error
from .geometry import pose_matrix
from .mesh import Mesh, joined

# The map's axes x, y, z are glTF's z, x, y.
_Z_UP_FROM_GLTF = [2, 0, 1]
_COMPRESSED = {"KHR_draco_mesh_compression": "Draco", "EXT_meshopt_compression": "meshopt"}
_TYPES = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_TRIANGLES = 4
_MOST_ELEMENTS = 1 << 28
READ_UNCOMPRESSED = ("read scene.uncompressed.glb beside it (option export.uncompressed_twin), or make one: "
                     "`deepslam expand map.json -o scene.glb --uncompressed`")


@dataclasses.dataclass(frozen=True, eq=False)
class GlbNode:
    """A node of a scene: its name, its labels (`extras`), where it stands, and its mesh, None where it has no triangles.

    The mesh is in the node's own frame with its scale in it, so that `world_from_node` (4x4) is rigid.
    """

    name: str
    extras: dict[str, Any]
    world_from_node: Floats
    mesh: Mesh | None


def needs_decoder(file: pathlib.Path) -> bool:
    """Whether the file's meshes are compressed."""
    return _compression(_Document(file).root) is not None


def read_glb(file: pathlib.Path) -> list[GlbNode]:
    """All nodes of the file, in its order."""
    document = _Document(file)
    if (name := _compression(document.root)) is not None:
        raise Error(file, "extensionsRequired", f"has {name}: its meshes are compressed by {_COMPRESSED[name]}, which this package "
                    "does not decode", READ_UNCOMPRESSED)
    return _Nodes(document).read()


def _compression(root: Node) -> str | None:
    required = root.maybe("extensionsRequired")
    return next((name for name in required.texts() if name in _COMPRESSED), None) if required else None


class _Document:
    """The two chunks of a binary glTF file, and its accessors as arrays."""

    def __init__(self, file: pathlib.Path) -> None:
        self.file = file
        data = read_bytes(file, "name a scene that is there; `deepslam run` and `deepslam expand` write them")
        if len(data) < 20 or data[:4] != b"glTF":
            raise Error(file, "", "is no binary glTF file", MAKE_ANEW)
        version, length = struct.unpack_from("<II", data, 4)
        if version != 2 or length != len(data):
            raise Error(file, "", f"says version {version} and {length} bytes, must be 2 and its size of {len(data)}", MAKE_ANEW)
        chunks: dict[bytes, bytes] = {}
        at = 12
        while at + 8 <= len(data):
            size, kind = struct.unpack_from("<I4s", data, at)
            if size > len(data) - at - 8:
                raise Error(file, "", f"has a chunk of {size} bytes at {at} that goes beyond its end", MAKE_ANEW)
            chunks.setdefault(kind, data[at + 8:at + 8 + size])
            at += 8 + size
        try:
            value = json.loads(chunks.get(b"JSON", b"").decode("utf-8"))
        except (ValueError, RecursionError) as fault:
            raise Error(file, "", f"has no whole JSON chunk: {fault}", MAKE_ANEW) from None
        self.root = Node(value, file, "")
        self.binary = chunks.get(b"BIN\0", b"")
        self.accessors = self._list("accessors")
        self.views = self._list("bufferViews")

    def _list(self, name: str) -> list[Node]:
        node = self.root.maybe(name)
        return node.items() if node else []

    def _pick(self, rows: list[Node], index: Node, what: str) -> Node:
        number = index.integer()
        if number >= len(rows):
            index.fail(f"is {number}, but there are {len(rows)} {what}")
        return rows[number]

    def array(self, index: Node) -> npt.NDArray[Any]:
        """(count, width); normalised integers as shares in [0, 1] or [-1, 1]."""
        accessor = self._pick(self.accessors, index, "accessors")
        if accessor.maybe("sparse"):
            accessor["sparse"].fail("is not read here", READ_UNCOMPRESSED)
        kind = accessor["componentType"].integer()
        if kind not in _TYPES:
            accessor["componentType"].fail(f"is {kind}, must be one of: {', '.join(map(str, _TYPES))}")
        dtype = np.dtype("<" + _TYPES[kind])
        width = _WIDTHS[accessor["type"].choice(tuple(_WIDTHS))]
        count = accessor["count"].integer(1, _MOST_ELEMENTS)
        view = self._pick(self.views, accessor["bufferView"], "buffer views")
        values = self._elements(view, accessor, (count, width), dtype)
        normalised = accessor.maybe("normalized")
        if normalised is None or normalised.value is not True or dtype.kind == "f":
            return values
        return np.maximum(values.astype(np.float64) / np.iinfo(dtype).max, -1)

    def _elements(self, view: Node, accessor: Node, shape: tuple[int, int], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
        buffer = self._pick(self._list("buffers"), view["buffer"], "buffers")
        if view["buffer"].integer() != 0 or buffer.maybe("uri"):
            view["buffer"].fail("is not the one in this file", READ_UNCOMPRESSED)
        start, size = _offset(view), view["byteLength"].integer(1)
        inner = _offset(accessor)
        packed = shape[1] * dtype.itemsize
        stride_node = view.maybe("byteStride")
        stride = stride_node.integer(packed, 252) if stride_node else packed
        if start + size > len(self.binary) or inner + stride * (shape[0] - 1) + packed > size:
            accessor.fail(f"goes beyond its buffer of {len(self.binary)} bytes")
        values = np.ndarray(shape, dtype, self.binary, start + inner, (stride, dtype.itemsize))
        return values


def _offset(node: Node) -> int:
    offset = node.maybe("byteOffset")
    return offset.integer() if offset else 0


class _Nodes:
    """The tree of nodes with what hangs on it."""

    def __init__(self, document: _Document) -> None:
        self.document = document
        self.rows = document._list("nodes")
        self.meshes = document._list("meshes")
        self.parents: dict[int, int] = {}
        for parent, row in enumerate(self.rows):
            children = row.maybe("children")
            for child in children.items() if children else []:
                if child.integer() >= len(self.rows) or child.integer() in self.parents:
                    child.fail(f"is {child.integer()}, which is no node of its own")
                self.parents[child.integer()] = parent

    def read(self) -> list[GlbNode]:
        return [self._node(number) for number in range(len(self.rows))]

    def _node(self, number: int) -> GlbNode:
        row = self.rows[number]
        world_from_node, at, steps = np.eye(4), number, 0
        while True:
            parent_from_node, scale = _local(self.rows[at])
            if at != number and not np.allclose(scale, 1):
                self.rows[at]["scale"].fail("is not read of a node that has others below it")
            world_from_node = parent_from_node @ world_from_node
            if at not in self.parents:
                break
            at, steps = self.parents[at], steps + 1
            if steps > len(self.rows):
                row.fail("is among its own children")
        name, extras = row.maybe("name"), row.maybe("extras")
        mesh = row.maybe("mesh")
        return GlbNode(name.text() if name else "", dict((key, value.value) for key, value in extras.members()) if extras else {},
                       world_from_node, self._mesh(mesh, _local(row)[1]) if mesh else None)

    def _mesh(self, index: Node, scale: Floats) -> Mesh | None:
        row = self.document._pick(self.meshes, index, "meshes")
        parts = []
        for primitive in row["primitives"].items():
            mode = primitive.maybe("mode")
            if mode is None or mode.integer() == _TRIANGLES:
                parts.append(self._triangles(primitive, scale))
        return joined(parts) if parts else None

    def _triangles(self, primitive: Node, scale: Floats) -> Mesh:
        attributes = primitive["attributes"]
        vertices = self._attribute(attributes["POSITION"], (3,)) * scale
        count = len(vertices)
        indices = primitive.maybe("indices")
        faces = (self.document.array(indices).astype(np.int64).reshape(-1) if indices else np.arange(count))
        if len(faces) % 3 or (len(faces) and faces.max() >= count):
            primitive.fail(f"has {len(faces)} corners over {count} vertices, must have triangles of them")
        normals, colours = attributes.maybe("NORMAL"), attributes.maybe("COLOR_0")
        return Mesh(
            vertices[:, _Z_UP_FROM_GLTF],
            faces.reshape(-1, 3),
            self._attribute(normals, (3,), count)[:, _Z_UP_FROM_GLTF] if normals else None,
            _srgb(self._attribute(colours, (3, 4), count)) if colours else None,
        )

    def _attribute(self, index: Node, widths: tuple[int, ...], count: int | None = None) -> Floats:
        values = self.document.array(index).astype(np.float64)
        if values.shape[1] not in widths or (count is not None and len(values) != count) or not np.isfinite(values).all():
            index.fail(f"must be {count if count is not None else 'some'} vectors of {widths[-1]} finite numbers")
        return values


def _local(row: Node) -> tuple[Floats, Floats]:
    """The node's rigid pose under its parent, z up, and its scale along glTF's axes."""
    if row.maybe("matrix"):
        row["matrix"].fail("is not read here, translation, rotation and scale are", READ_UNCOMPRESSED)
    rotation, translation, scale = row.maybe("rotation"), row.maybe("translation"), row.maybe("scale")
    shift = translation.numbers(3)[_Z_UP_FROM_GLTF] if translation else np.zeros(3)
    turn = np.array([0.0, 0.0, 0.0, 1.0])
    if rotation:
        turn = rotation.numbers(4)[[*_Z_UP_FROM_GLTF, 3]]
        norm = float(np.linalg.norm(turn))
        if not 0.99 < norm < 1.01:  # floats of 32 bits, and of other programs
            rotation.fail(f"has length {norm:g}, must be a quaternion of length 1")
        turn /= norm
    return pose_matrix(turn, shift), scale.numbers(3, 1e-6, 1e6) if scale else np.ones(3)


def _srgb(linear: Floats) -> npt.NDArray[np.uint8]:
    """Linear colours in [0, 1], with or without opacity, as sRGB bytes with it (IEC 61966-2-1)."""
    rgba = np.ones((len(linear), 4))
    rgba[:, :linear.shape[1]] = np.clip(linear, 0, 1)
    rgb = rgba[:, :3]
    rgba[:, :3] = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)
    return np.round(255 * rgba).astype(np.uint8)
