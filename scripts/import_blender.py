"""Run by scripts/import_blender.sh inside Blender: imports a GLB, prints what Blender made of it."""
import json
import sys

import bpy
import numpy

if not hasattr(numpy, "bool"):
    numpy.bool = bool  # the importer of Blender 3.4 wants the alias that numpy 1.24 took away

LABELS = ("class", "instance", "score", "prior", "views", "credit")


def plain(value):
    return value.to_list() if hasattr(value, "to_list") else value


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=sys.argv[sys.argv.index("--") + 1])
rows = []
for thing in bpy.data.objects:
    row = {"name": thing.name, "type": thing.type, "size_m": [round(side, 4) for side in thing.dimensions],
           "at_m": [round(x, 4) for x in thing.matrix_world.translation]}
    if thing.type == "MESH":
        row["faces"] = len(thing.data.polygons)
        row["materials"] = [material.name for material in thing.data.materials]
        row["vertex_colours"] = len(thing.data.color_attributes) > 0
    row.update({label: plain(thing[label]) for label in LABELS if label in thing.keys()})
    rows.append(row)
print("SCENE " + json.dumps(rows))
