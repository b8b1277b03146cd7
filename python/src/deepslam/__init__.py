"""Labelled object maps in Python: opens what the program `deepslam` wrote, and runs it.

    import deepslam
    scene = deepslam.open("workspace")
    for thing in scene.objects:
        print(thing.name, thing.confidence, thing.world_from_object[:3, 3], thing.size_m)
    print(scene.trajectory.length_m, "m of camera path")

Frames and units are those of the map: metres, seconds, z up, floor at z = 0; transforms are 4x4 matrices `b_from_a`. Whatever
cannot be used raises `Error`, which names file, field, value and remedy.
"""
from .batch import Batch, BatchCapture, open_batch
from .candidates import Candidate, Proposal
from .errors import Error, InputUnusable, Interrupted, ProgramError, ProgramMissing, RunFailed, UsageError
from .geometry import OrientedBox
from .layout import Layout, Opening, Room, Wall
from .mesh import Mesh
from .program import Progress, RunResult, expand, find_program, run
from .relations import Label, Relation
from .scene import Scene, SceneObject, open
from .trajectory import Trajectory

__version__ = "0.1.0"

__all__ = [
    "Batch", "BatchCapture", "Candidate", "Error", "InputUnusable", "Interrupted", "Label", "Layout", "Mesh", "Opening",
    "OrientedBox", "ProgramError", "ProgramMissing", "Progress", "Proposal", "Relation", "Room", "RunFailed", "RunResult", "Scene",
    "SceneObject", "Trajectory", "UsageError", "Wall", "expand", "find_program", "open", "open_batch", "run",
]
