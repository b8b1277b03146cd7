"""Reads the triangles out of a GLB without Draco, and counts by itself whether they close. Shares no code with deepslam."""
import collections
import json
import struct

SIZES = {5121: ("B", 1), 5123: ("H", 2), 5125: ("I", 4), 5126: ("f", 4)}


def read_glb(path):
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[20 + length + 8:]


def numbers(document, binary, index, width):
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    assert "byteStride" not in view, "packed"
    letter, size = SIZES[accessor["componentType"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    flat = struct.unpack_from(f"<{accessor['count'] * width}{letter}", binary, start)
    assert size * len(flat) <= view["byteLength"]
    return [flat[i:i + width] for i in range(0, len(flat), width)]


def triangles(document, binary, mesh):
    """Corner triples of places, so that vertices doubled at creases count once."""
    faces = []
    for primitive in document["meshes"][mesh]["primitives"]:
        places = numbers(document, binary, primitive["attributes"]["POSITION"], 3)
        indices = [i for i, in numbers(document, binary, primitive["indices"], 1)]
        faces += [tuple(places[i] for i in indices[n:n + 3]) for n in range(0, len(indices), 3)]
    return faces


def objects(path):
    """Name -> faces of every labelled node."""
    document, binary = read_glb(path)
    return {node["name"]: triangles(document, binary, node["mesh"]) for node in document["nodes"]
            if "class" in node.get("extras", {}) and "mesh" in node}


def faults(faces):
    """Why these faces are no closed, consistently oriented two-manifold; empty when they are one."""
    edges = collections.Counter()
    fans = collections.defaultdict(dict)  # vertex -> edge by edge round it
    for a, b, c in faces:
        if len({a, b, c}) < 3:
            return ["a face without area"]
        for u, v, w in ((a, b, c), (b, c, a), (c, a, b)):
            edges[u, v] += 1
            fans[u][v] = w
    found = []
    if any(count != 1 for count in edges.values()):
        found.append("an edge runs twice in one direction")
    if any((v, u) not in edges for u, v in edges):
        found.append("an edge has one face")
    for vertex, fan in fans.items():
        start = next(iter(fan))
        at, steps = fan[start], 1
        while at != start and at in fan and steps <= len(fan):
            at, steps = fan[at], steps + 1
        if steps != len(fan):
            found.append("two fans meet in a vertex")
            break
    return found


def volume(faces):
    """Positive when faces look outwards."""
    return sum(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]) for a, b, c in faces) / 6
