"""export/map.json: the compact map, as it is stored."""
from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Mapping

from .documents import Floats, Node, read_document
from .geometry import read_pose
from .layout import Layout, read_layout

VERDICTS = ("good", "doubtful", "bad")
_FAR_M = 1e5


@dataclasses.dataclass(frozen=True, eq=False)
class CompactObject:
    """An object of the map; `scene.SceneObject` says what its fields mean."""

    id: int
    name: str
    class_name: str
    confidence: float
    source: str
    world_from_object: Floats
    size_m: Floats
    credit: str
    note: str
    room: int | None
    stands_on: str | None
    against_wall: int | None


@dataclasses.dataclass(frozen=True, eq=False)
class CompactMap:
    """The file, less what only `deepslam expand` needs."""

    tool_version: str
    capture_name: str
    capture_hash: str
    verdict: str
    reasons: tuple[str, ...]
    class_colours: Mapping[str, tuple[int, int, int]]
    ground_outline_m: Floats
    layout: Layout | None
    objects: tuple[CompactObject, ...]


def read_map(file: pathlib.Path) -> CompactMap:
    """Version 5, and 4, which has no layout."""
    root = read_document(file, "deepslam/map", 5, 4, missing="name a map.json of `deepslam run`, or its workspace")
    node = root.maybe("layout")
    layout = read_layout(node) if node else None
    objects = tuple(_object(row, layout) for row in root["objects"].items())
    for row, before, after in zip(root["objects"].items()[1:], objects, objects[1:]):
        if after.id <= before.id:
            row["id"].fail(f"is {after.id}, must be above {before.id}, the one before it")
    if len({each.name for each in objects}) != len(objects):
        root["objects"].fail("has one name twice")
    outline = root["ground_outline_m"].numbers(None, -_FAR_M, _FAR_M)
    if len(outline) % 2:
        root["ground_outline_m"].fail("must hold x and y in turn")
    return CompactMap(
        root["tool_version"].text(), root["capture_name"].text(), root["capture_hash"].text(), root["verdict"].choice(VERDICTS),
        root["reasons"].texts(), {name: _colour(colour) for name, colour in root["class_colours"].members()},
        outline.reshape(-1, 2), layout, objects)


def _colour(node: Node) -> tuple[int, int, int]:
    red, green, blue = (channel.integer(0, 255) for channel in node.items(3))
    return red, green, blue


def _object(row: Node, layout: Layout | None) -> CompactObject:
    rooms, walls = (len(layout.rooms), len(layout.walls)) if layout else (0, 0)
    stands_on = row.maybe("stands_on")
    return CompactObject(
        row["id"].integer(), row["name"].text(), row["class"].text(), row["confidence"].number(0, 1), row["source"].text(),
        read_pose(row["world_from_object"]), row["size_m"].numbers(3, 0, _FAR_M), row["credit"].text(), row["note"].text(),
        _place(row, "room", rooms), stands_on.text() if stands_on else None, _place(row, "against_wall", walls))


def _place(row: Node, name: str, count: int) -> int | None:
    node = row.maybe(name)
    if node is not None and node.integer() >= count:
        node.fail(f"is {node.integer()}, but the map has {count} of them")
    return node.integer() if node else None
