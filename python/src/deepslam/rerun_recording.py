"""A map as a recording of Rerun (rerun-sdk), by Scene.to_rerun."""
from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING

import numpy as np

from .errors import Error
from .layout import Layout
from .mesh import Mesh

if TYPE_CHECKING:
    import rerun

    from .scene import Scene

_TIMELINE = "capture"
_PATH_COLOUR = (40, 40, 40)
_OPENING_COLOURS = {"door": (150, 90, 40), "window": (70, 140, 220), "passage": (120, 120, 120)}
_WALL_COLOUR = (150, 150, 150)
_LINE_M = 0.01  # radius of lines
# The picture that the camera's frustum is drawn with: half as high as wide is far, by eye.
_FRUSTUM_WIDTH, _FRUSTUM_HEIGHT = 4, 3


def write_recording(scene: Scene, file: pathlib.Path) -> None:
    """Objects under `objects`, the room under `room`, the path and the moving camera under `camera`; z up."""
    try:
        import rerun as rr
    except ImportError as fault:
        raise Error(file, "", f"cannot be written: {fault}", "install the extra: `pip install deepslam[rerun]`") from None
    # The same map gives the same recording's name, so that opening it again replaces it.
    name = f"{scene.capture_name}-{scene.capture_hash[:16]}"
    recording = rr.RecordingStream("deepslam", recording_id=name, send_properties=False)
    try:
        recording.save(file)
    except (OSError, RuntimeError) as fault:
        raise Error(file, "", f"cannot be written: {fault}", "choose a file in a folder that you may write to") from None
    recording.log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    _log_objects(recording, scene)
    for part, mesh in scene.surroundings.items():
        recording.log(["room", part], _mesh(mesh), static=True)
    if scene.layout is not None:
        _log_layout(recording, scene.layout)
    if scene.workspace is not None:
        _log_path(recording, scene)
    recording.flush()
    recording.disconnect()


def _mesh(mesh: Mesh) -> rerun.Mesh3D:
    import rerun as rr

    return rr.Mesh3D(vertex_positions=mesh.vertices_m, triangle_indices=mesh.faces, vertex_normals=mesh.normals,
                     vertex_colors=mesh.colours)


def _log_objects(recording: rerun.RecordingStream, scene: Scene) -> None:
    import rerun as rr

    for each in scene.objects:
        box, colour = each.box, scene.class_colours.get(each.class_name, _WALL_COLOUR)
        recording.log(
            ["objects", each.name, "box"],
            rr.Transform3D(translation=box.centre_m, mat3x3=box.world_from_box[:3, :3]),
            rr.Boxes3D(half_sizes=[box.size_m / 2], labels=[f"{each.name} {each.confidence:.2f}"], colors=[colour]),
            rr.AnyValues(class_name=each.class_name, confidence=each.confidence, source=each.source, note=each.note),
            static=True)
        if len(each.mesh.faces):
            recording.log(["objects", each.name, "mesh"], _mesh(each.mesh_world), static=True)


def _log_layout(recording: rerun.RecordingStream, layout: Layout) -> None:
    import rerun as rr

    for wall in layout.walls:
        outline = np.concatenate([wall.corners_m, wall.corners_m[:1]])
        recording.log(f"layout/wall_{wall.id:02}", rr.LineStrips3D([outline], colors=[_WALL_COLOUR], radii=_LINE_M), static=True)
    for opening in layout.openings:
        outline = np.concatenate([opening.corners_m, opening.corners_m[:1]])
        recording.log(f"layout/{opening.kind}_{opening.id:02}",
                      rr.LineStrips3D([outline], colors=[_OPENING_COLOURS[opening.kind]], radii=_LINE_M), static=True)


def _log_path(recording: rerun.RecordingStream, scene: Scene) -> None:
    import rerun as rr

    path = scene.trajectory
    recording.log("camera/path", rr.LineStrips3D([path.positions_m], colors=[_PATH_COLOUR], radii=_LINE_M), static=True)
    recording.log("camera/now", rr.Pinhole(focal_length=_FRUSTUM_WIDTH, width=_FRUSTUM_WIDTH, height=_FRUSTUM_HEIGHT,
                                           camera_xyz=rr.ViewCoordinates.RDF), static=True)
    rr.send_columns(
        "camera/now",
        indexes=[rr.TimeColumn(_TIMELINE, duration=path.times_s - path.times_s[0])],
        columns=rr.Transform3D.columns(translation=path.positions_m, mat3x3=path.world_from_camera[:, :3, :3]),
        recording=recording)
