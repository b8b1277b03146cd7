"""How objects, rooms and walls stand to each other, and what common label sets call them: export/scene_graph.json."""
from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Mapping

from .documents import Node, read_document
from .geometry import OrientedBox, pose_matrix

PREDICATES = ("in_room", "stands_on", "hangs_on", "against_wall", "next_to", "in_front_of")
_FAR_M = 1e6


@dataclasses.dataclass(frozen=True)
class Relation:
    """`subject` `predicate` `object`, by names: chair_03 next_to table_01. docs/scene_graph.schema.json defines the predicates."""

    subject: str  # an object
    predicate: str  # in_room, stands_on, hangs_on, against_wall, next_to, in_front_of
    object: str  # an object, a room, a wall, or `floor`
    distance_m: float | None  # on the floor plan; of next_to and in_front_of


@dataclasses.dataclass(frozen=True)
class Label:
    """A class of a label set: 56 chair."""

    id: int  # in its set
    name: str  # in its set


@dataclasses.dataclass(frozen=True, eq=False)
class GraphObject:
    """What the scene graph has of an object beyond the map."""

    name: str
    labels: Mapping[str, Label]  # by set: coco, nyu40, scannet200; without those that have no such class
    box: OrientedBox
    has_front: bool
    volume_m3: float


@dataclasses.dataclass(frozen=True, eq=False)
class SceneGraph:
    """The file's own part: relations, and labels and boxes by object's id."""

    capture_hash: str
    objects: Mapping[int, GraphObject]
    relations: tuple[Relation, ...]


def read_scene_graph(file: pathlib.Path) -> SceneGraph:
    """The file checked against itself: relations name what is in it."""
    root = read_document(
        file, "deepslam/scene_graph", 1,
        missing="run `deepslam run` on its workspace again, with a program that writes it")
    objects = {}
    for row in root["objects"].items():
        number = row["id"].integer()
        if number in objects:
            row["id"].fail(f"is {number}, which another object has as well")
        objects[number] = _object(row)
    things = {thing.name for thing in objects.values()}
    places = {row["name"].text() for rows in ("rooms", "walls") for row in root[rows].items()} | {"floor"}
    relations = tuple(_relation(row, things, places) for row in root["relations"].items())
    return SceneGraph(root["capture_hash"].text(), objects, relations)


def _object(row: Node) -> GraphObject:
    box = row["oriented_box"]
    labels = {name: Label(label["id"].integer(), label["name"].text()) for name, label in row["labels"].members()}
    has_front = row["has_front"]
    if not isinstance(has_front.value, bool):
        has_front.fail("must be true or false")
    return GraphObject(
        row["name"].text(), labels,
        OrientedBox(pose_matrix(box["rotation_xyzw"].quaternion(), box["centre_m"].numbers(3, -_FAR_M, _FAR_M)),
                    box["size_m"].numbers(3, 0, _FAR_M)),
        has_front.value, row["volume_m3"].number(0))


def _relation(row: Node, things: set[str], places: set[str]) -> Relation:
    subject, other = row["subject"].text(), row["object"].text()
    if subject not in things:
        row["subject"].fail(f'is "{subject}", which is no object of the file')
    if other not in things and other not in places:
        row["object"].fail(f'is "{other}", which is nothing in the file')
    distance = row.maybe("distance_m")
    return Relation(subject, row["predicate"].choice(PREDICATES), other, distance.number(0) if distance else None)
