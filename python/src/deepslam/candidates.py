"""Why each object is what it is: the shapes that were proposed for it, and their scores."""
from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Iterable, Mapping

from .documents import Floats, Node, read_document


@dataclasses.dataclass(frozen=True, eq=False)
class Proposal:
    """Where a candidate's shape comes from."""

    source: str  # retrieval, fused, network, mean_latent, refined, completed
    model: str  # stem of models/<model>.binvox in the folder of its stage
    library_id: str  # of a CAD model; empty: none
    credit: str  # creator and licence of a CAD model; empty: none
    proposal_score: float  # the source's own opinion, comparable within one source only
    size_m: float  # longest side as the source believes; 0: unknown
    stretch: Floats  # (3,): factors of a CAD model's proportions; ones: as it is


@dataclasses.dataclass(frozen=True, eq=False)
class Candidate:
    """A shape that was proposed for an object, and how well it agrees with all depth of the object."""

    id: int  # over all objects
    chosen: bool  # whether it is the object's shape
    score: float  # what decides
    surface_share: float  # of the object's depth points, within tolerance of the model
    coverage_share: float  # of the model's surface that should be seen, what is
    free_violation: float  # share of rays that pass through the model before their measured depth
    seen_share: float  # of the whole model's surface, what some view confirmed
    num_views: int  # that it was placed in
    note: str  # why it could not be scored, or what was unsure
    proposal: Proposal | None  # None where the files of proposals were dropped (`deepslam batch --keep final`)


@dataclasses.dataclass(frozen=True, eq=False)
class StoredObject:
    """What stage `optimize` keeps of an object beyond the map."""

    class_votes: Mapping[str, float]  # sums of scores, by class
    frames: tuple[int, ...]  # that saw it
    merged: tuple[int, ...]  # ids of objects that loops found to be this one
    candidates: tuple[Candidate, ...]  # best first


def read_stored_objects(file: pathlib.Path, proposals: Mapping[int, Proposal]) -> tuple[dict[int, StoredObject], tuple[str, ...]]:
    """Objects of objects.json by id, and those that got no place in the map, with the reason."""
    root = read_document(file, "deepslam/objects", 1)
    objects = {row["id"].integer(): _stored(row, proposals) for row in root["objects"].items()}
    return objects, root["dropped"].texts()


def read_proposals(files: Iterable[pathlib.Path]) -> dict[int, Proposal]:
    """Proposals by the candidate's id; ids are unique over the stages."""
    return {row["id"].integer(): _proposal(row)
            for file in files for row in read_document(file, "deepslam/candidates", 2)["candidates"].items()}


def _stored(row: Node, proposals: Mapping[int, Proposal]) -> StoredObject:
    votes, chosen = row.maybe("class_votes"), row.maybe("chosen")
    winner = chosen.integer() if chosen else None
    return StoredObject(
        {name: votes_of.number(0) for name, votes_of in votes.members()} if votes else {},
        tuple(view["frame"].integer() for view in row["views"].items()),
        row["merged"].integers(),
        tuple(_candidate(score, winner, proposals) for score in row["scores"].items()))


def _candidate(row: Node, winner: int | None, proposals: Mapping[int, Proposal]) -> Candidate:
    number = row["candidate"].integer()
    return Candidate(
        number, number == winner, row["score"].number(), row["surface_share"].number(), row["coverage_share"].number(),
        row["free_violation"].number(), row["seen_share"].number(), row["num_views"].integer(), row["note"].text(),
        proposals.get(number))


def _proposal(row: Node) -> Proposal:
    return Proposal(row["source"].text(), row["model"].text(), row["library_id"].text(), row["credit"].text(),
                    row["proposal_score"].number(), row["size_m"].number(0), row["stretch"].numbers(3, 0, 1e6))
