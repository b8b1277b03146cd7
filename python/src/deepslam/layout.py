"""The room itself: rooms, walls and openings, in the map's world (z up)."""
from __future__ import annotations

import dataclasses

import numpy as np

from .documents import Floats, Node

_FAR_M = 1e4
KINDS = ("door", "window", "passage")


@dataclasses.dataclass(frozen=True, eq=False)
class Room:
    """A room by the corners of its floor, counter-clockwise; an edge without a wall was not seen."""

    id: int  # position in the list
    polygon_m: Floats  # (n, 2): x, y
    floor_m: float  # height of the floor
    ceiling_m: float | None  # height of the ceiling; None: not seen

    @property
    def area_m2(self) -> float:
        """Of the polygon."""
        x, y = self.polygon_m.T
        return float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)


@dataclasses.dataclass(frozen=True, eq=False)
class _Upright:
    """An upright rectangle: its ends on the floor plan and its heights."""

    id: int  # position in the list
    from_m: Floats  # (2,): x, y
    to_m: Floats  # (2,): x, y
    bottom_m: float  # height of its lower edge
    top_m: float  # height of its upper edge
    confidence: float  # [0, 1]

    @property
    def length_m(self) -> float:
        """On the floor plan."""
        return float(np.linalg.norm(self.to_m - self.from_m))

    @property
    def corners_m(self) -> Floats:
        """(4, 3) in the world: along the lower edge, and back along the upper one."""
        (ax, ay), (bx, by) = self.from_m, self.to_m
        return np.array([[ax, ay, self.bottom_m], [bx, by, self.bottom_m], [bx, by, self.top_m], [ax, ay, self.top_m]])


@dataclasses.dataclass(frozen=True, eq=False)
class Wall(_Upright):
    """A face of a wall. Walking from `from_m` to `to_m` its room lies to the left."""

    rooms: tuple[int, ...]  # ids of the rooms whose it is; none: its room was not closed
    seen_share: float  # of its length, [0, 1]


@dataclasses.dataclass(frozen=True, eq=False)
class Opening(_Upright):
    """A door, window or passage in a wall; below a confidence of 0.5 it is doubtful."""

    wall: int  # id of the wall that it is in
    kind: str  # door, window, passage


@dataclasses.dataclass(frozen=True, eq=False)
class Layout:
    """All of it. Ids are positions in these lists."""

    rooms: tuple[Room, ...]  # closed by walls
    walls: tuple[Wall, ...]  # faces of walls
    openings: tuple[Opening, ...]  # in them


def read_layout(node: Node) -> Layout:
    """The member `layout` of map.json."""
    rooms = tuple(_room(row, n) for n, row in enumerate(node["rooms"].items()))
    walls = tuple(
        Wall(*_upright(row, n), tuple(room.integer(0, len(rooms) - 1) for room in row["rooms"].items()),
             row["seen_share"].number(0, 1)) for n, row in enumerate(node["walls"].items()))
    openings = tuple(
        Opening(*_upright(row, n), row["wall"].integer(0, len(walls) - 1), row["kind"].choice(KINDS))
        for n, row in enumerate(node["openings"].items()))
    return Layout(rooms, walls, openings)


def _room(row: Node, number: int) -> Room:
    _check_id(row, number)
    polygon = row["polygon_m"].numbers(None, -_FAR_M, _FAR_M)
    if len(polygon) < 6 or len(polygon) % 2:
        row["polygon_m"].fail(f"has {len(polygon)} numbers, must have x, y of three corners or more")
    floor_m = row["floor_m"].number(-_FAR_M, _FAR_M)
    ceiling = row.maybe("ceiling_m")
    return Room(number, polygon.reshape(-1, 2), floor_m, ceiling.number(floor_m, _FAR_M) if ceiling else None)


def _upright(row: Node, number: int) -> tuple[int, Floats, Floats, float, float, float]:
    _check_id(row, number)
    bottom_m = row["bottom_m"].number(-_FAR_M, _FAR_M)
    return (number, row["from_m"].numbers(2, -_FAR_M, _FAR_M), row["to_m"].numbers(2, -_FAR_M, _FAR_M), bottom_m,
            row["top_m"].number(bottom_m, _FAR_M), row["confidence"].number(0, 1))


def _check_id(row: Node, number: int) -> None:
    if row["id"].integer() != number:
        row["id"].fail(f"is {row['id'].integer()}, must be {number}, its place in the list")
