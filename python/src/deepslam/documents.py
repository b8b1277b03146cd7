"""JSON files of the program, read without trust: every value is asked for by name, type and range."""
from __future__ import annotations

import json
import math
import pathlib
from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from .errors import Error

MAKE_ANEW = "take a whole copy of it, or run `deepslam run` on its workspace again, which makes damaged files anew"
# Of a number that was written in full or to seven digits, as the program's own limit.
_UNIT_TOLERANCE = 1e-6
# More bytes than the largest files have that are read whole; half an hour of frames takes 10 MB.
_MOST_BYTES = 2 << 30

Floats = npt.NDArray[np.float64]


class Node:
    """A value of a JSON document with its place in it, for messages."""

    def __init__(self, value: Any, file: pathlib.Path, path: str) -> None:
        self.value = value
        self.file = file
        self.path = path

    def fail(self, problem: str, remedy: str = MAKE_ANEW) -> NoReturn:
        raise Error(self.file, self.path, problem, remedy)

    def _kind(self, wanted: str) -> NoReturn:
        text = json.dumps(self.value)
        self.fail(f"is {text if len(text) < 60 else text[:57] + '...'}, must be {wanted}")

    def __getitem__(self, key: str) -> Node:
        node = self.maybe(key)
        if node is None:
            self.fail(f'has no member "{key}"')
        return node

    def maybe(self, key: str) -> Node | None:
        """A member that may be missing or null."""
        if not isinstance(self.value, dict):
            self._kind("an object")
        value = self.value.get(key)
        return None if value is None else Node(value, self.file, f"{self.path}.{key}" if self.path else key)

    def text(self) -> str:
        if not isinstance(self.value, str):
            self._kind("a text")
        return self.value

    def choice(self, names: Sequence[str]) -> str:
        if self.value not in names:
            self._kind("one of: " + ", ".join(names))
        return self.text()

    def number(self, low: float = -math.inf, high: float = math.inf) -> float:
        if isinstance(self.value, bool) or not isinstance(self.value, (int, float)):
            self._kind("a number")
        try:
            number = float(self.value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number) or not low <= number <= high:
            self._kind(f"a number in [{low:g}, {high:g}]")
        return number

    def integer(self, low: int = 0, high: int = (1 << 31) - 1) -> int:
        if isinstance(self.value, bool) or not isinstance(self.value, int) or not low <= self.value <= high:
            self._kind(f"a whole number in [{low}, {high}]")
        return self.value

    def items(self, count: int | None = None) -> list[Node]:
        if not isinstance(self.value, list):
            self._kind("a list")
        if count is not None and len(self.value) != count:
            self.fail(f"has {len(self.value)} entries, must have {count}")
        return [Node(value, self.file, f"{self.path}[{n}]") for n, value in enumerate(self.value)]

    def members(self) -> Iterator[tuple[str, Node]]:
        if not isinstance(self.value, dict):
            self._kind("an object")
        for key, value in self.value.items():
            yield key, Node(value, self.file, f"{self.path}.{key}" if self.path else key)

    def numbers(self, count: int | None = None, low: float = -math.inf, high: float = math.inf) -> Floats:
        return np.array([node.number(low, high) for node in self.items(count)], dtype=np.float64)

    def texts(self) -> tuple[str, ...]:
        return tuple(node.text() for node in self.items())

    def integers(self) -> tuple[int, ...]:
        return tuple(node.integer() for node in self.items())

    def quaternion(self) -> Floats:
        """x, y, z, w, of length 1."""
        rotation_xyzw = self.numbers(4)
        norm = float(np.linalg.norm(rotation_xyzw))
        if abs(norm - 1) > _UNIT_TOLERANCE:
            self.fail(f"has length {norm:g}, must be a quaternion of length 1")
        return rotation_xyzw / norm


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"holds {name}, which is no number of JSON")


def read_bytes(file: pathlib.Path, missing: str) -> bytes:
    """The file whole. `missing`: what to do where it is not there."""
    try:
        if file.stat().st_size > _MOST_BYTES:
            raise Error(file, "", f"has {file.stat().st_size} bytes, must have {_MOST_BYTES} at most", MAKE_ANEW)
        return file.read_bytes()
    except FileNotFoundError:
        raise Error(file, "", "is missing", missing) from None
    except OSError as fault:
        raise Error(file, "", f"cannot be read: {fault.strerror or fault}", "see who may read it") from None


def read_document(file: pathlib.Path, name: str, newest: int, oldest: int | None = None, *, missing: str = MAKE_ANEW) -> Node:
    """A document of format `name` in a version from `oldest` (by default `newest`) to `newest`."""
    data = read_bytes(file, missing)
    try:
        value = json.loads(data.decode("utf-8"), parse_constant=_refuse_constant)
    except RecursionError:
        raise Error(file, "", "is nested too deeply for any file of deepslam", MAKE_ANEW) from None
    except ValueError as fault:  # of JSON and of UTF-8
        raise Error(file, "", f"is no whole JSON document: {fault}", MAKE_ANEW) from None
    root = Node(value, file, "")
    if not isinstance(value, dict):
        root.fail(f'is no document of format "{name}"')
    found = root["format"].text()
    if found != name:
        root["format"].fail(f'is "{found}", must be "{name}"', "name the file that is meant")
    version = root["version"].integer(low=-(1 << 31))
    if version > newest:
        root["version"].fail(f"is {version}, newer than {newest}, the newest that this package knows",
                             "install the package `deepslam` that came with the program that wrote it")
    if version < (newest if oldest is None else oldest):
        root["version"].fail(f"is {version}, older than {newest if oldest is None else oldest}, the oldest that is read",
                             "run `deepslam run` on its workspace again, which writes it anew")
    return root
