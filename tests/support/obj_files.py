"""Wavefront OBJ, as exports have it."""
import numpy


def volume_of(path):
    """Of a closed one."""
    vertices, faces = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[0] == "v":
            vertices.append([float(word) for word in words[1:4]])
        elif words[0] == "f":
            faces.append([int(word) - 1 for word in words[1:4]])
    vertices, faces = numpy.array(vertices), numpy.array(faces)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return numpy.einsum("ij,ij->i", a, numpy.cross(b, c)).sum() / 6
