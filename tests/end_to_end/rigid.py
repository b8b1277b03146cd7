"""Rigid motions in plain lists: rotations are rows, quaternions x y z w."""
import math


def rotation_of(quaternion):
    x, y, z, w = quaternion
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


def transposed(m):
    return [list(row) for row in zip(*m)]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def apply(m, p):
    return [sum(m[i][k] * p[k] for k in range(3)) for i in range(3)]


def add(a, b):
    return [x + y for x, y in zip(a, b)]


def subtract(a, b):
    return [x - y for x, y in zip(a, b)]


def read_tum(file):
    """Pose (rotation, translation) by time to the millisecond."""
    poses = {}
    for line in file.read_text(encoding="utf-8").splitlines():
        if line.strip() and not line.startswith("#"):
            time, *numbers = map(float, line.split())
            poses[round(time, 3)] = (rotation_of(numbers[3:]), numbers[:3])
    return poses


def mean_motion(pairs):
    """The motion b_from_a that is the mean over pairs of poses (b_from_camera, a_from_camera)."""
    motions = [product(b[0], transposed(a[0])) for b, a in pairs]
    total = [[sum(m[i][j] for m in motions) for j in range(3)] for i in range(3)]
    rotation = orthonormal(total)
    shifts = [subtract(b[1], apply(rotation, a[1])) for b, a in pairs]
    return rotation, [sum(s[k] for s in shifts) / len(shifts) for k in range(3)]


def orthonormal(m):
    """The rotation nearest to a matrix near one: Newton's iteration for the polar decomposition."""
    scale = math.sqrt(3 / sum(x * x for row in m for x in row))
    m = [[scale * x for x in row] for row in m]
    for _ in range(30):
        inverse = transposed(inverted(m))
        m = [[(m[i][j] + inverse[i][j]) / 2 for j in range(3)] for i in range(3)]
    return m


def inverted(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    cofactors = [[e * i - f * h, c * h - b * i, b * f - c * e], [f * g - d * i, a * i - c * g, c * d - a * f],
                 [d * h - e * g, b * g - a * h, a * e - b * d]]
    determinant = a * cofactors[0][0] + b * cofactors[1][0] + c * cofactors[2][0]
    return [[x / determinant for x in row] for row in cofactors]
