#!/usr/bin/env python3
"""Furniture of Infinigen's generators as meshes to train on (train.sh --meshes FOLDER).

    infinigen_meshes.py --out FOLDER [--kinds SofaFactory,ChairFactory] [--first 100] [--count 240] [--faces 6000]

Writes FOLDER/CLASS/KIND_SEED.obj: metres, y up, z front, on the floor, at most so many triangles. What is there is kept; a
design that fails is told and left out. Needs Python 3.11 and the packages of infinigen_requirements.txt in an environment of
its own. Credit: "Infinigen (Raistrick et al. 2023, 2024), BSD 3-Clause".
"""
import argparse
import importlib
import pathlib
import sys

import bpy
import numpy as np

# Factory: module below infinigen.assets.objects, class.
KINDS = {
    "SofaFactory": ("seating.sofa", "sofa"),
    "ArmChairFactory": ("seating.sofa", "chair"),
    "ChairFactory": ("seating.chairs.chair", "chair"),
    "OfficeChairFactory": ("seating.chairs.office_chair", "chair"),
    "BarChairFactory": ("seating.chairs.bar_chair", "chair"),
    "SimpleBookcaseFactory": ("shelves.simple_bookcase", "shelf"),
    "CellShelfFactory": ("shelves.cell_shelf", "shelf"),
    "LargeShelfFactory": ("shelves.large_shelf", "shelf"),
    "TriangleShelfFactory": ("shelves.triangle_shelf", "shelf"),
    "TableDiningFactory": ("tables.dining_table", "table"),
    "CoffeeTableFactory": ("tables.dining_table", "table"),
    "SideTableFactory": ("tables.dining_table", "table"),
    "TableCocktailFactory": ("tables.cocktail_table", "table"),
}


def clear():
    for found in list(bpy.data.objects):
        bpy.data.objects.remove(found, do_unlink=True)
    for kind in (bpy.data.meshes, bpy.data.materials, bpy.data.node_groups, bpy.data.curves):
        for found in list(kind):
            kind.remove(found)


def surface(objects):
    """Vertices (world, z up, x front) and triangles of all of them, modifiers applied."""
    graph, vertices, faces, count = bpy.context.evaluated_depsgraph_get(), [], [], 0
    for one in objects:
        if one.type != "MESH":
            continue
        mesh = one.evaluated_get(graph).to_mesh()
        mesh.calc_loop_triangles()
        place = np.array(one.matrix_world)
        points = np.empty(3 * len(mesh.vertices))
        mesh.vertices.foreach_get("co", points)
        vertices.append(points.reshape(-1, 3) @ place[:3, :3].T + place[:3, 3])
        corners = np.empty(3 * len(mesh.loop_triangles), int)
        mesh.loop_triangles.foreach_get("vertices", corners)
        faces.append(corners.reshape(-1, 3) + count)
        count += len(mesh.vertices)
    return np.vstack(vertices), np.vstack(faces)


def thinned(vertices, faces, most):
    if len(faces) <= most:
        return vertices, faces
    mesh = bpy.data.meshes.new("thinned")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    one = bpy.data.objects.new("thinned", mesh)
    bpy.context.collection.objects.link(one)
    one.modifiers.new("decimate", "DECIMATE").ratio = most / len(faces)
    bpy.context.view_layer.update()
    return surface([one])


def wide(vertices):
    """Turned about z so that the longer side runs across (y), as that of tables does in the canonical frame."""
    deep, broad, _ = np.ptp(vertices, axis=0)
    return vertices[:, [1, 0, 2]] * [1, -1, 1] if deep > broad else vertices


def write(path, vertices, faces):
    middle = 0.5 * (vertices.min(0) + vertices.max(0))
    placed = (vertices - [middle[0], middle[1], vertices[:, 2].min()])[:, [1, 2, 0]]
    lines = ["v %.4f %.4f %.4f" % tuple(p) for p in placed] + ["f %d %d %d" % tuple(f) for f in faces + 1]
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_suffix(".partial")
    aside.write_text("\n".join(lines) + "\n", encoding="utf-8")
    aside.replace(path)


def make(kind, seed, most):
    clear()
    np.random.seed(seed)
    module = importlib.import_module("infinigen.assets.objects." + KINDS[kind][0])
    spawned = getattr(module, kind)(seed).spawn_asset(i=0)
    vertices, faces = surface([spawned, *spawned.children_recursive])
    if KINDS[kind][1] == "table":
        vertices = wide(vertices)
    return thinned(vertices, faces, most)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--first", type=int, default=100, help="seed of the first design")
    parser.add_argument("--count", type=int, default=100, help="designs of each kind")
    parser.add_argument("--faces", type=int, default=6000)
    arguments = parser.parse_args()
    kinds = arguments.kinds.split(",")
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        parser.error(f"--kinds: {', '.join(unknown)} unknown; known are {', '.join(KINDS)}")
    failed = 0
    for kind in kinds:
        for seed in range(arguments.first, arguments.first + arguments.count):
            path = arguments.out / KINDS[kind][1] / f"{kind}_{seed}.obj"
            if path.exists():
                continue
            try:
                write(path, *make(kind, seed, arguments.faces))
            except Exception as error:  # a generator's own failure takes down its design only
                failed += 1
                print(f"{kind} {seed}: {error!r}", file=sys.stderr, flush=True)
    print(f"{failed} designs failed")


if __name__ == "__main__":
    main()
