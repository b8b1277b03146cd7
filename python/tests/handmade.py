"""A workspace by hand: two boxes in a room of one wall, with every number known; and a writer of small scenes."""
from __future__ import annotations

import json
import pathlib
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
HASH = "5c" * 32
HALF = 0.5 ** 0.5
# The chair is turned by 90 degrees about z, the table not; both stand on the floor.
CHAIR = {"rotation_xyzw": [0, 0, HALF, HALF], "translation_m": [1.0, 2.0, 0.5]}
TABLE = {"rotation_xyzw": [0, 0, 0, 1], "translation_m": [-1.0, 0.0, 0.35]}
CHAIR_SIZE, TABLE_SIZE = [0.4, 0.6, 1.0], [0.8, 1.6, 0.7]
CORNERS = np.array([[(n >> axis) & 1 for axis in range(3)] for n in range(8)], dtype=np.float64) - 0.5
# Counter-clockwise seen from outside; rows of CORNERS.
BOX_FACES = np.array([
    [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
    [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]])


def map_object(number: int, name: str, class_name: str, pose: Any, size: Any, **more: Any) -> dict[str, Any]:
    return {"id": number, "name": name, "class": class_name, "confidence": 0.75, "source": "retrieval", "world_from_object": pose,
            "scale_m": max(size), "size_m": size, "credit": "", "note": "", "shape": {"voxels_base64": "AAAA"}, **more}


def compact_map() -> dict[str, Any]:
    wall = {"id": 0, "rooms": [0], "from_m": [3, -2], "to_m": [3, 2], "bottom_m": 0, "top_m": 2.5, "seen_share": 0.9, "confidence": 0.8}
    door = {"id": 0, "wall": 0, "kind": "door", "from_m": [3, -1], "to_m": [3, 0], "bottom_m": 0, "top_m": 2, "confidence": 0.6}
    room = {"id": 0, "polygon_m": [-3, -2, 3, -2, 3, 2, -3, 2], "floor_m": 0, "ceiling_m": None}
    return {
        "format": "deepslam/map", "version": 5, "tool_version": "0.1.0", "capture_name": "by hand", "capture_hash": HASH,
        "class_colours": {"chair": [230, 126, 34], "table": [52, 152, 219]}, "ground_world": {"normal": [0, 0, 1], "d_m": 0},
        "ground_outline_m": [-3, -2, 3, -2, 3, 2, -3, 2], "mesh_options": {}, "verdict": "doubtful", "reasons": ["made by hand"],
        "layout": {"rooms": [room], "walls": [wall], "openings": [door]},
        "objects": [map_object(0, "chair_00", "chair", CHAIR, CHAIR_SIZE, room=0, stands_on="floor", against_wall=0),
                    map_object(3, "table_03", "table", TABLE, TABLE_SIZE)]}


def scene_graph() -> dict[str, Any]:
    def thing(of_map: dict[str, Any], volume_m3: float) -> dict[str, Any]:
        pose = of_map["world_from_object"]
        return {**{key: of_map[key] for key in ("id", "name", "class", "confidence", "source", "world_from_object", "size_m")},
                "labels": {"coco": {"id": 56, "name": "chair"}} if of_map["class"] == "chair" else {},
                "oriented_box": {"centre_m": pose["translation_m"], "size_m": of_map["size_m"], "rotation_xyzw": pose["rotation_xyzw"]},
                "has_front": True, "has_mesh": True, "volume_m3": volume_m3, "room": of_map.get("room")}

    of_map = compact_map()
    return {"format": "deepslam/scene_graph", "version": 1, "capture_hash": HASH, "rooms": [{"id": 0, "name": "room_00"}],
            "walls": [{"id": 0, "name": "wall_00"}], "openings": [],
            "objects": [thing(of_map["objects"][0], 0.24), thing(of_map["objects"][1], 0.896)],
            "relations": [{"subject": "chair_00", "predicate": "in_room", "object": "room_00"},
                          {"subject": "chair_00", "predicate": "next_to", "object": "table_03", "distance_m": 0.4}]}


def stored_objects() -> dict[str, Any]:
    def score(candidate: int, value: float) -> dict[str, Any]:
        return {"candidate": candidate, "score": value, "surface_share": 0.9, "coverage_share": 0.8, "free_violation": 0.05,
                "num_views": 2, "seen_share": 0.5, "note": "", "views": []}

    def thing(number: int, name: str, scores: list[dict[str, Any]]) -> dict[str, Any]:
        return {"id": number, "class": name, "class_votes": {name: 3.5, "couch": 0.25}, "chosen": scores[0]["candidate"], "merged": [],
                "views": [{"frame": 0}, {"frame": 2}], "scores": scores}

    return {"format": "deepslam/objects", "version": 1, "dropped": ["object 7: no candidate could be placed"],
            "objects": [thing(0, "chair", [score(1, 0.9), score(0, 0.6)]), thing(3, "table", [score(2, 0.8)])]}


def candidates(*numbers: int) -> dict[str, Any]:
    return {"format": "deepslam/candidates", "version": 2, "notes": [], "models": [f"model_{n}" for n in numbers], "candidates": [
        {"id": n, "object": 0, "source": "retrieval", "view": None, "model": f"model_{n}", "proposal_score": 0.5, "size_m": 1,
         "min_size_m": 0.5, "max_size_m": 2, "latents": [], "library_id": f"catalogue/{n}", "credit": "", "stretch": [1, 1, 1]}
        for n in numbers]}


TUM = "# time_s tx ty tz qx qy qz qw\n0 0 0 1.5 0 0 0 1\n0.1 0.3 0 1.5 0 0 0 1\n0.2 0.3 0.4 1.5 0 0 1 0\n"


def frames() -> dict[str, Any]:
    rows = [{"frame": n, "time_s": n / 10, "status": status, "keyframe": 0, "rmse_m": 0, "inlier_share": 1}
            for n, status in enumerate(("tracked", "lost", "tracked"))]
    return {"format": "deepslam/frames", "version": 1, "frames": rows, "keyframes": [0, 2], "composed_edges": []}


def write(folder: pathlib.Path) -> pathlib.Path:
    """The workspace, whole."""
    for stage in ("export", "optimize", "associate", "propose", "select", "loops"):
        (folder / stage).mkdir(parents=True)
    for name, document in {
        "workspace.json": {"format": "deepslam/workspace", "version": 1},
        "export/map.json": compact_map(),
        "export/scene_graph.json": scene_graph(),
        "optimize/objects.json": stored_objects(),
        "optimize/frames.json": frames(),
        "associate/tracks.json": {"format": "deepslam/tracks", "version": 1, "tracks": [], "rejections": [],
                                  "not_mapped": ["tv seen in 3 frames: flush in a wall, as a picture is"]},
        "propose/candidates.json": candidates(0, 2),
        "select/candidates.json": candidates(1),
        "loops/candidates.json": candidates(),
    }.items():
        (folder / name).write_text(json.dumps(document))
    (folder / "optimize/trajectory.tum").write_text(TUM)
    (folder / "export/scene.uncompressed.glb").write_bytes(scene_glb())
    (folder / "export/scene.glb").write_bytes(scene_glb(compressed=True))
    return folder


class GlbWriter:
    """Puts arrays into one buffer; `document` is changed at will before `pack`."""

    def __init__(self) -> None:
        self.binary = b""
        self.document: dict[str, Any] = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                                         "accessors": [], "bufferViews": []}

    def accessor(self, values: Array, kind: str, **more: Any) -> int:
        types = {"f4": 5126, "u2": 5123, "u4": 5125, "i2": 5122, "u1": 5121}
        self.binary += bytes(-len(self.binary) % 4)
        self.document["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": values.nbytes})
        self.document["accessors"].append({
            "bufferView": len(self.document["bufferViews"]) - 1, "componentType": types[values.dtype.str[1:]], "count": len(values),
            "type": kind, **more})
        self.binary += values.tobytes()
        return len(self.document["accessors"]) - 1

    def mesh(self, vertices: Array, faces: Array, colour: tuple[int, ...] | None = None, **more: Any) -> int:
        """`vertices` along glTF's axes."""
        attributes = {"POSITION": self.accessor(vertices, "VEC3", **more)}
        if colour:
            attributes["COLOR_0"] = self.accessor(np.tile(np.array(colour, "<u2"), (len(vertices), 1)), "VEC4", normalized=True)
        primitive = {"attributes": attributes, "indices": self.accessor(faces.reshape(-1).astype("<u2"), "SCALAR"), "mode": 4}
        self.document["meshes"].append({"primitives": [primitive]})
        return len(self.document["meshes"]) - 1

    def node(self, **node: Any) -> int:
        self.document["nodes"].append(node)
        return len(self.document["nodes"]) - 1

    def pack(self) -> bytes:
        self.document["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + bytes(-len(self.binary) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
        return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def to_gltf(points: Array) -> Array:
    """The map's axes x, y, z along glTF's: y, z, x."""
    return np.ascontiguousarray(points[:, [1, 2, 0]].astype("<f4"))


def gltf_place(pose: dict[str, Any]) -> dict[str, Any]:
    x, y, z = pose["translation_m"]
    qx, qy, qz, qw = pose["rotation_xyzw"]
    return {"translation": [y, z, x], "rotation": [qy, qz, qx, qw]}


def scene_glb(compressed: bool = False, chair: str = "chair_00") -> bytes:
    """The chair as it is, the table as a unit box with a scale, and a floor."""
    writer = GlbWriter()
    own = writer.mesh(to_gltf(CORNERS * CHAIR_SIZE), BOX_FACES, (65535, 0, 32768, 65535))
    unit = writer.mesh(to_gltf(CORNERS), BOX_FACES)
    floor = writer.mesh(to_gltf(np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0]])), np.array([[0, 1, 2]]))
    sx, sy, sz = TABLE_SIZE
    writer.node(name=chair, mesh=own, extras={"class": "chair", "instance": 0}, **gltf_place(CHAIR))
    writer.node(name="table_03", mesh=unit, extras={"class": "table", "instance": 3}, scale=[sy, sz, sx], **gltf_place(TABLE))
    writer.node(name="ground", mesh=floor)
    if compressed:
        writer.document["extensionsUsed"] = writer.document["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    return writer.pack()
