"""Whether files of deepslam are sound: `python3 -m deepslam.check PATH ...`, where PATH is a workspace, a map.json or a
file whose name ends in scene_graph.json. Reads all that is there, says the first fault of each, and ends with exit code 3 where
there was one."""
from __future__ import annotations

import pathlib
import sys
from collections.abc import Sequence

from . import scene
from .errors import Error
from .relations import read_scene_graph


def check(path: pathlib.Path) -> str:
    """What was found sound, in words."""
    if path.name.endswith("scene_graph.json"):
        graph = read_scene_graph(path)
        return f"{len(graph.objects)} objects, {len(graph.relations)} relations"
    opened = scene.open(path)
    parts = [f"{len(opened.objects)} objects, {opened.verdict}"]
    beside = opened.map_file.parent
    if (beside / "scene_graph.json").exists():
        parts.append(f"{len(opened.relations)} relations")
    if (beside / "scene.uncompressed.glb").exists():
        parts.append(f"{sum(len(mesh.faces) for mesh in opened.meshes.values())} faces")
        parts.append(f"{len(opened.surroundings)} parts around them")
    if opened.workspace is not None:
        parts.append(f"{len(opened.trajectory)} poses")
        parts.append(f"{sum(len(each.candidates) for each in opened.objects)} candidates")
    return ", ".join(parts)


def main(arguments: Sequence[str]) -> int:
    """Exit code 0: all sound; 2: no path was given; 3: a fault."""
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__)
        return 0 if arguments else 2
    code = 0
    for argument in arguments:
        try:
            print(f"{argument}: {check(pathlib.Path(argument))}")
        except Error as fault:
            print(f"error: {fault}", file=sys.stderr)
            code = 3
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
