"""A map with all that its workspace knows: objects, the room around them, the camera path, and why things are as they are."""
from __future__ import annotations

import functools
import os
import pathlib
import tempfile
from collections.abc import Mapping

import numpy as np

from . import glb, program
from .candidates import Candidate, Proposal, StoredObject, read_proposals, read_stored_objects
from .compact_map import CompactMap, CompactObject, read_map
from .documents import Floats, read_document
from .errors import Error
from .geometry import OrientedBox
from .layout import Layout
from .mesh import EMPTY, Mesh
from .relations import GraphObject, Label, Relation, SceneGraph, read_scene_graph
from .trajectory import Trajectory, read_trajectory

StrPath = str | os.PathLike[str]
_GO_ON = "`deepslam run CAPTURE -o WORKSPACE` goes on where it was stopped"


class SceneObject:
    """One thing of the map.

    Its own frame is metric: x front, y left, z up. What needs more files than the map (`votes`, `frames`, `candidates`: the
    workspace; `labels`: scene_graph.json; `mesh`: a scene) reads them when it is asked for, and raises `Error` without them.
    """

    def __init__(self, scene: Scene, stored: CompactObject) -> None:
        self._scene = scene
        self._map_object = stored
        self.id: int = stored.id  # not a position in the list
        self.name: str = stored.name  # in all outputs: `chair_03`
        self.class_name: str = stored.class_name  # of the table of classes
        self.confidence: float = stored.confidence  # in [0, 1]
        self.source: str = stored.source  # of its shape: retrieval, fused, network, mean_latent, refined, completed
        self.world_from_object: Floats = stored.world_from_object  # (4, 4), rigid
        self.size_m: Floats = stored.size_m  # (3,): along its front, left and up
        self.credit: str = stored.credit  # creator and licence of a CAD model; empty: none
        self.note: str = stored.note  # what is doubtful about it, in words; empty: nothing
        self.room: int | None = stored.room  # id of the room that holds its middle; None: none
        self.stands_on: str | None = stored.stands_on  # `floor`, `wall` (it hangs), or the object below; None: not known
        self.against_wall: int | None = stored.against_wall  # id of the wall within 15 cm of a side of it; None: none

    def __repr__(self) -> str:
        return f"<{self.name}, {self.confidence:.2f}>"

    @property
    def box(self) -> OrientedBox:
        """The box along its axes: that of its mesh where scene_graph.json is there, else its size about its frame's origin,
        which lies within a voxel (1/64 of its longest side) of the middle."""
        graph = self._scene._graph_object(self.id)
        return graph.box if graph is not None else OrientedBox(self.world_from_object, self.size_m)

    @property
    def mesh(self) -> Mesh:
        """Its closed surface in its own frame; without faces where none could be made."""
        return self._scene.meshes[self.name]

    @property
    def mesh_world(self) -> Mesh:
        """The same in the world."""
        return self.mesh.transformed(self.world_from_object)

    @property
    def votes(self) -> Mapping[str, float]:
        """What the detector calls it: sums of scores by class."""
        return self._scene._stored_object(self.id).class_votes

    @property
    def frames(self) -> tuple[int, ...]:
        """Frames that saw it."""
        return self._scene._stored_object(self.id).frames

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """Shapes that were proposed for it, best first."""
        return self._scene._stored_object(self.id).candidates

    @property
    def labels(self) -> Mapping[str, Label]:
        """Its class in common label sets: coco, nyu40, scannet200; without those that have no such class."""
        return self._scene._graph.objects[self.id].labels

    @property
    def relations(self) -> tuple[Relation, ...]:
        """Those that it is the subject or the object of."""
        return tuple(each for each in self._scene.relations if self.name in (each.subject, each.object))


class Scene:
    """A map. `open` makes it; the map itself is read at once, everything else when it is asked for."""

    def __init__(self, map_file: pathlib.Path, workspace: pathlib.Path | None, program_file: StrPath | None = None) -> None:
        self.map_file: pathlib.Path = map_file  # the map.json that was read
        self.workspace: pathlib.Path | None = workspace  # the folder of the run; None: the map was opened alone
        self._program = program_file
        self._map: CompactMap = read_map(map_file)
        self.objects: tuple[SceneObject, ...] = tuple(SceneObject(self, each) for each in self._map.objects)  # by ascending id

    def __repr__(self) -> str:
        return f"<Scene of {self.capture_name}: {len(self.objects)} objects, {self.verdict}>"

    @property
    def tool_version(self) -> str:
        """Version of the program that made it."""
        return self._map.tool_version

    @property
    def capture_name(self) -> str:
        """The capture's folder or file, by its last name."""
        return self._map.capture_name

    @property
    def capture_hash(self) -> str:
        """SHA-256 of the capture."""
        return self._map.capture_hash

    @property
    def verdict(self) -> str:
        """`good`, `doubtful` (look at `reasons`) or `bad` (not to be used)."""
        return self._map.verdict

    @property
    def reasons(self) -> tuple[str, ...]:
        """Of the verdict, in words."""
        return self._map.reasons

    @property
    def class_colours(self) -> Mapping[str, tuple[int, int, int]]:
        """sRGB, of the classes in the map."""
        return self._map.class_colours

    @property
    def ground_outline_m(self) -> Floats:
        """(n, 2): the seen floor as a polygon, x and y of its corners. Empty: no ground was found."""
        return self._map.ground_outline_m

    @property
    def layout(self) -> Layout | None:
        """Rooms, walls and openings; None in maps of versions that had none."""
        return self._map.layout

    def object(self, key: int | str) -> SceneObject:
        """The object of an id or a name."""
        for each in self.objects:
            if key in (each.id, each.name):
                return each
        known = ", ".join(each.name for each in self.objects) or "none"
        raise Error(self.map_file, "objects", f"has no object {key!r}", f"there are: {known}")

    @functools.cached_property
    def trajectory(self) -> Trajectory:
        """The camera path, a pose for every frame."""
        return read_trajectory(self._stage("optimize"))

    @functools.cached_property
    def _graph(self) -> SceneGraph:
        """scene_graph.json beside the map."""
        graph = read_scene_graph(self._beside("scene_graph.json"))
        names = {each.id: each.name for each in self.objects}
        if graph.capture_hash != self.capture_hash or names != {n: each.name for n, each in graph.objects.items()}:
            raise Error(self._beside("scene_graph.json"), "", "is of another run than the map beside it", _GO_ON)
        return graph

    @property
    def relations(self) -> tuple[Relation, ...]:
        """How objects stand to each other, to rooms and to walls: scene_graph.json."""
        return self._graph.relations

    def _graph_object(self, number: int) -> GraphObject | None:
        """What scene_graph.json has of an object; None where there is no such file."""
        return self._graph.objects[number] if self._beside("scene_graph.json").exists() else None

    @functools.cached_property
    def not_mapped(self) -> tuple[str, ...]:
        """What was seen and is no object of the map, with the reason, in words."""
        file = self._stage("associate") / "tracks.json"
        seen = read_document(file, "deepslam/tracks", 1).maybe("not_mapped")
        return (*(seen.texts() if seen else ()), *self._stored[1])

    @functools.cached_property
    def _stored(self) -> tuple[dict[int, StoredObject], tuple[str, ...]]:
        folder = self._stage("optimize")
        proposals: dict[int, Proposal] = {}
        if not any((folder.parent / stage / "dropped.json").exists() for stage in ("propose", "select", "loops")):
            proposals = read_proposals(self._stage(stage) / "candidates.json" for stage in ("propose", "select", "loops"))
        return read_stored_objects(folder / "objects.json", proposals)

    def _stored_object(self, number: int) -> StoredObject:
        """What the workspace knows of an object beyond the map."""
        if number not in self._stored[0]:
            raise Error(self._stage("optimize") / "objects.json", "objects", f"has no object {number}, which the map has", _GO_ON)
        return self._stored[0][number]

    @functools.cached_property
    def meshes(self) -> Mapping[str, Mesh]:
        """Surfaces of all objects by name, each in its object's own frame; `open` says where they come from."""
        for name in ("scene.uncompressed.glb", "scene.glb"):
            file = self._beside(name)
            if file.exists() and not glb.needs_decoder(file):
                return self._object_meshes(file)
        return self.expand()

    def expand(self, *, library: StrPath | None = None, data: StrPath | None = None) -> Mapping[str, Mesh]:
        """Surfaces of all objects made again from the map alone, by `deepslam expand` (which needs the furniture library)."""
        with tempfile.TemporaryDirectory(prefix="deepslam-") as folder:
            file = pathlib.Path(folder) / "scene.glb"
            program.expand(self.map_file, file, library=library, data=data, program=self._program)
            return self._object_meshes(file)

    @functools.cached_property
    def surroundings(self) -> Mapping[str, Mesh]:
        """What stands around the objects, in the world, by the scene's names: ground, room, wall_00, door_01, ..."""
        file = self._beside("scene.uncompressed.glb")
        names = {each.name for each in self.objects}
        return {node.name: node.mesh.transformed(node.world_from_node)
                for node in glb.read_glb(file if file.exists() else self._beside("scene.glb"))
                if node.mesh is not None and node.name not in names}

    def to_rerun(self, path: StrPath) -> None:
        """Writes a recording (.rrd) that the Rerun viewer opens: objects as boxes and meshes, walls, the camera path in time.

        Needs the extra: `pip install deepslam[rerun]`.
        """
        from .rerun_recording import write_recording

        write_recording(self, pathlib.Path(path))

    def _object_meshes(self, file: pathlib.Path) -> dict[str, Mesh]:
        nodes = {node.name: node for node in glb.read_glb(file) if "class" in node.extras}
        meshes = {}
        for each in self.objects:
            if each.name not in nodes:
                raise Error(file, "nodes", f'has no node "{each.name}", an object of {self.map_file}',
                            "give the scene that was made with this map")
            meshes[each.name] = nodes[each.name].mesh or EMPTY
            if not np.allclose(nodes[each.name].world_from_node, each.world_from_object, atol=1e-3):
                raise Error(file, f'node "{each.name}"', f"stands elsewhere than in {self.map_file}",
                            "give the scene that was made with this map")
        return meshes

    def _beside(self, name: str) -> pathlib.Path:
        return self.map_file.parent / name

    def _stage(self, stage: str) -> pathlib.Path:
        """The folder of a stage, where it has its files."""
        if self.workspace is None:
            raise Error(self.map_file, "", f"is a map alone, without what stage {stage} wrote", "open its workspace")
        folder = self.workspace / stage
        if (folder / "dropped.json").exists():
            raise Error(folder, "", "has no files any more: they were dropped (`deepslam batch --keep final`)",
                        f"`deepslam run CAPTURE -o {self.workspace} --force {stage}` makes them again")
        if not folder.is_dir():
            raise Error(folder, "", "is missing: the run has not come to this stage", _GO_ON)
        return folder


def open(path: StrPath, *, program: StrPath | None = None) -> Scene:
    """Opens a workspace of `deepslam run`, or a map.json alone.

    A map in its workspace's folder `export` knows the workspace; one that lies elsewhere has objects and layout. Meshes are read
    from a scene beside it that is not compressed by Draco (scene.uncompressed.glb, which every run writes), else made by
    `deepslam expand`, in the colours of classes, where the program (`program`, see `find_program`) is found.
    """
    place = pathlib.Path(path)
    if place.is_dir():
        if not (place / "workspace.json").exists() and (place / "map.json").exists():
            return open(place / "map.json", program=program)
        _check_workspace(place)
        map_file = place / "export" / "map.json"
        if not map_file.exists():
            raise Error(map_file, "", "is missing: the run has not come to stage export", _GO_ON)
        return Scene(map_file, place, program)
    folder = place.absolute().parent
    if folder.name == "export" and (folder.parent / "workspace.json").exists():
        _check_workspace(folder.parent)
        return Scene(place, folder.parent, program)
    return Scene(place, None, program)


def _check_workspace(folder: pathlib.Path) -> None:
    read_document(folder / "workspace.json", "deepslam/workspace", 1,
                  missing="name a folder that `deepslam run` made, or a map.json")
