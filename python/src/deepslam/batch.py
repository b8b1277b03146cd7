"""Results of `deepslam batch`: one entry per capture of its batch.json."""
from __future__ import annotations

import dataclasses
import os
import pathlib
from collections.abc import Mapping

from . import scene
from .documents import Node, read_document

STATES = ("waiting", "running", "done", "failed", "interrupted")


@dataclasses.dataclass(frozen=True, eq=False)
class BatchCapture:
    """A capture of a batch and what became of it."""

    name: str  # of its workspace
    capture: str  # path
    workspace: pathlib.Path  # may be missing where it has not run
    state: str  # waiting, running, done, failed, interrupted
    reason: str  # why it failed and what to do; empty: it has not
    exit_code: int  # with which `deepslam run` would have ended
    verdict: str  # good, doubtful or bad; empty: no map yet
    verdict_reasons: tuple[str, ...]  # in words
    objects: Mapping[str, int]  # number by class
    ate_rmse_m: float | None  # error of the camera path, where poses came with the capture
    wall_s: float  # of all attempts

    def open(self) -> scene.Scene:
        """Its map."""
        return scene.open(self.workspace)


@dataclasses.dataclass(frozen=True, eq=False)
class Batch:
    """All captures of a batch, in its order."""

    folder: pathlib.Path  # that holds batch.json
    tool_version: str  # of the program
    state: str  # of the whole
    captures: tuple[BatchCapture, ...]  # all of them

    @property
    def done(self) -> tuple[BatchCapture, ...]:
        """Those that have a map."""
        return tuple(each for each in self.captures if each.state == "done")


def open_batch(path: str | os.PathLike[str]) -> Batch:
    """Opens the folder that `deepslam batch` wrote, or its batch.json."""
    place = pathlib.Path(path)
    file = place / "batch.json" if place.is_dir() else place
    root = read_document(file, "deepslam/batch", 1, missing="name a folder that `deepslam batch` made")
    return Batch(file.parent, root["tool_version"].text(), root["state"].text(),
                 tuple(_capture(row, file.parent) for row in root["captures"].items()))


def _capture(row: Node, folder: pathlib.Path) -> BatchCapture:
    name = row["name"].text()
    if name in ("", ".", "..") or "/" in name:
        row["name"].fail(f'is "{name}", must be the name of a folder in the batch')
    ate = row.maybe("ate")
    return BatchCapture(
        name, row["capture"].text(), folder / name, row["state"].choice(STATES), row["reason"].text(),
        row["exit_code"].integer(-(1 << 31)), row["verdict"].text(), row["verdict_reasons"].texts(),
        {kind: count.integer() for kind, count in row["objects"].members()}, ate["rmse_m"].number(0) if ate else None,
        row["wall_s"].number(0))
