"""Run by scripts/import_blender.sh inside Blender: imports a scene, prints what Blender made of it, draws it if asked to."""
import json
import math
import os
import sys

import bpy
import mathutils
import numpy

if not hasattr(numpy, "bool"):
    numpy.bool = bool  # the importer of Blender 3.4 wants the alias that numpy 1.24 took away

LABELS = ("class", "instance", "score", "prior", "views", "credit")
SAMPLES = 32  # a pixel: enough for a look


def plain(value):
    return value.to_list() if hasattr(value, "to_list") else value


def is_usd(path):
    return path.endswith((".usda", ".usdc", ".usdz", ".usd"))


def read(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if is_usd(path):
        bpy.ops.wm.usd_import(filepath=path)
    else:
        bpy.ops.import_scene.gltf(filepath=path)


def rows():
    for thing in bpy.data.objects:
        row = {"name": thing.name, "type": thing.type, "size_m": [round(side, 4) for side in thing.dimensions],
               "at_m": [round(x, 4) for x in thing.matrix_world.translation]}
        if thing.type == "MESH":
            row["faces"] = len(thing.data.polygons)
            row["materials"] = [material.name for material in thing.data.materials]
            row["vertex_colours"] = len(thing.data.color_attributes) > 0
        row.update({label: plain(thing[label]) for label in LABELS if label in thing.keys()})
        yield row


def hide(names):
    for thing in bpy.data.objects:
        above = thing
        while above is not None:
            if above.name in names:
                thing.hide_render = True
            above = above.parent


def show_vertex_colours():
    """Blender's importer of glTF leaves them unconnected."""
    for thing in bpy.data.objects:
        if thing.type != "MESH" or not thing.data.color_attributes:
            continue
        for material in thing.data.materials:
            nodes, links = material.node_tree.nodes, material.node_tree.links
            surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
            if not surface.inputs["Base Color"].is_linked:
                colours = nodes.new("ShaderNodeVertexColor")
                colours.layer_name = thing.data.color_attributes[0].name
                links.new(colours.outputs["Color"], surface.inputs["Base Color"])


def box_of_the_seen():
    corners = [thing.matrix_world @ mathutils.Vector(corner) for thing in bpy.data.objects
               if thing.type == "MESH" and not thing.hide_render for corner in thing.bound_box]
    corners = numpy.array(corners or [[-1, -1, 0], [1, 1, 1]])
    return corners.min(axis=0), corners.max(axis=0)


def point_at(thing, target, direction):
    """Looks along -z from `direction` to the target."""
    thing.rotation_euler = mathutils.Vector(direction).to_track_quat("Z", "Y").to_euler()
    thing.location = target


def draw(path, yaw_deg, pitch_deg, z_turned):
    """The view that scripts/render_glb.sh has."""
    low, high = box_of_the_seen()
    centre, radius = mathutils.Vector((low + high) / 2), max(1e-3, float(numpy.linalg.norm(high - low)) / 2)
    yaw, pitch = math.radians(yaw_deg), math.radians(pitch_deg)
    flat = (math.sin(yaw), -math.cos(yaw)) if z_turned else (math.cos(yaw), math.sin(yaw))
    direction = mathutils.Vector((flat[0] * math.cos(pitch), flat[1] * math.cos(pitch), math.sin(pitch)))
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.sensor_fit, camera.data.angle_y = "VERTICAL", math.radians(35)
    camera.data.clip_start, camera.data.clip_end = radius / 100, radius * 20
    point_at(camera, centre + direction * radius * 2.9, direction)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 1.5
    point_at(sun, centre, direction + mathutils.Vector((0.4, 0.6, 1.2)))
    for thing in (camera, sun):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.9, 0.9, 0.9, 1)
    scene.render.engine = "CYCLES"  # needs no graphics card
    scene.cycles.device, scene.cycles.samples, scene.cycles.max_bounces = "CPU", SAMPLES, 3
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = 1200, 900
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def main(file, picture=None, yaw_deg="35", pitch_deg="30"):
    read(file)
    print("SCENE " + json.dumps(list(rows())))
    if picture is not None:
        hide(set(filter(None, os.environ.get("DEEPSLAM_HIDE", "").split(","))))
        show_vertex_colours()
        draw(picture, float(yaw_deg), float(pitch_deg), not is_usd(file))


main(*sys.argv[sys.argv.index("--") + 1:])
