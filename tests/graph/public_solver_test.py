#!/usr/bin/env python3
"""The graph's solver beside GTSAM on SE(3) graphs in g2o form: the same energy to 1e-4.

    public_solver_test.py SOLVE_G2O [--size N]

Standard graphs are those that GTSAM's package carries: sphere2500 in TORO's form, which is put into g2o's, and small ones
in g2o form as they are. Others are made here: a sphere and a torus of poses and a grid, each with noise on its edges. Big
ones start from the chain of their odometry. Both solvers minimise sum r^T I r with
r = t2v(z^-1 x_i^-1 x_j), translation and rotation vector; GTSAM is given this residual, with its derivatives, as a factor
of its own, since its own BetweenFactor takes the logarithm of SE(3). Skipped (77) without GTSAM.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("solve", metavar="SOLVE_G2O", help="the program deepslam_solve_g2o")
parser.add_argument("--size", type=int, default=1, help="factor on the graphs' sizes (default: 1)")
ARGUMENTS = parser.parse_args()

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import python_packages  # noqa: E402

gtsam, np = python_packages.need("gtsam", "numpy")

SOLVE, SIZE = ARGUMENTS.solve, ARGUMENTS.size
TRANSLATION_M, ROTATION_RAD = 0.05, 0.02


def hat(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def exp(v):
    return gtsam.Rot3.Expmap(v).matrix()


def pose(rotation, translation):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation
    return matrix


def looking_at(point, centre):
    forward = (centre - point) / np.linalg.norm(centre - point)
    right = np.cross(forward, [0.1, 0.2, 1.0])
    right /= np.linalg.norm(right)
    return pose(np.stack([right, np.cross(forward, right), forward], axis=1), point)


def sphere(rings, per_ring):
    truth = []
    for k in range(rings * per_ring):
        up = np.pi * (k / (rings * per_ring) - 0.5)
        round_ = 2 * np.pi * k / per_ring
        point = 10 * np.array([np.cos(up) * np.cos(round_), np.cos(up) * np.sin(round_), np.sin(up)])
        truth.append(looking_at(point, np.zeros(3)))
    return truth, [(k, k + per_ring) for k in range(len(truth) - per_ring)]


def torus(rings, per_ring):
    truth = []
    for k in range(rings * per_ring):
        big, small = 2 * np.pi * k / (rings * per_ring), 2 * np.pi * k / per_ring
        middle = 8 * np.array([np.cos(big), np.sin(big), 0])
        point = middle + 3 * (np.cos(small) * middle / 8 + np.sin(small) * np.array([0, 0, 1.0]))
        truth.append(looking_at(point, middle))
    count = len(truth)
    return truth, [(k, (k + per_ring) % count) for k in range(count)]


def grid(side, _):
    random = np.random.default_rng(5)
    truth, at = [], {}
    for row in range(side):
        for step in range(side):
            column = step if row % 2 == 0 else side - 1 - step
            at[row, column] = len(truth)
            truth.append(pose(exp(random.normal(0, 1, 3)), np.array([column, row, 0.3 * np.sin(row + column)])))
    return truth, [(at[r, c], at[r + 1, c]) for r in range(side - 1) for c in range(side) if at[r + 1, c] != at[r, c] + 1]


def information(random):
    root = random.normal(0, 0.2, (6, 6)) + np.eye(6)
    scale = np.diag([1 / TRANSLATION_M] * 3 + [1 / ROTATION_RAD] * 3)
    return scale @ root @ root.T @ scale


def measured(truth, loops, seed):
    """Edges (i, j, i_from_j, information) and the chain of the odometry."""
    random = np.random.default_rng(seed)
    edges = []
    for i, j in [(k, k + 1) for k in range(len(truth) - 1)] + loops:
        error = pose(exp(random.normal(0, ROTATION_RAD, 3)), random.normal(0, TRANSLATION_M, 3))
        edges.append((i, j, np.linalg.inv(truth[i]) @ truth[j] @ error, information(random)))
    chain = [truth[0]]
    for _, _, relative, _ in edges[:len(truth) - 1]:
        chain.append(chain[-1] @ relative)
    return edges, chain


def carried(name):
    """A file of those that come with GTSAM."""
    return pathlib.Path(gtsam.findExampleDataFile(name))


def symmetric(upper):
    matrix = np.zeros((6, 6))
    matrix[np.triu_indices(6)] = upper
    return matrix + matrix.T - np.diag(np.diag(matrix))


def read_toro(path):
    """Edges of a file in TORO's form (i j x y z roll pitch yaw, information of the same), and the chain of its odometry."""
    edges, chain = [], [np.eye(4)]
    for words in map(str.split, path.read_text(encoding="ascii").splitlines()):
        i, j, numbers = int(words[1]), int(words[2]), [float(word) for word in words[3:]]
        edges.append((i, j, pose(gtsam.Rot3.RzRyRx(*numbers[3:6]).matrix(), numbers[:3]), symmetric(numbers[6:])))
        if i + 1 == j == len(chain):
            chain.append(chain[-1] @ edges[-1][2])
    return edges, chain


def quaternion(rotation):
    q = gtsam.Rot3(rotation).toQuaternion()
    return [q.x(), q.y(), q.z(), q.w()]


def write_g2o(path, edges, chain):
    """g2o counts half the rotation vector: its information is D I D with D = (1, 1, 1, 2, 2, 2)."""
    d = np.diag([1, 1, 1, 2, 2, 2.0])

    def numbers(values):
        return " ".join(repr(float(v)) for v in values)

    with open(path, "w", encoding="ascii") as file:
        for k, matrix in enumerate(chain):
            file.write(f"VERTEX_SE3:QUAT {k} {numbers([*matrix[:3, 3], *quaternion(matrix[:3, :3])])}\n")
        for i, j, relative, weight in edges:
            upper = (d @ weight @ d)[np.triu_indices(6)]
            file.write(f"EDGE_SE3:QUAT {i} {j} {numbers([*relative[:3, 3], *quaternion(relative[:3, :3]), *upper])}\n")


def read_g2o(path):
    """Edges and poses; the file's information is of g2o's error, see write_g2o."""
    edges, poses = [], {}
    d = np.diag([1, 1, 1, 0.5, 0.5, 0.5])
    for words in map(str.split, pathlib.Path(path).read_text(encoding="ascii").splitlines()):
        first = {"VERTEX_SE3:QUAT": 2, "EDGE_SE3:QUAT": 3}.get(words[0] if words else "")
        if first is None:
            continue
        x, y, z, qx, qy, qz, qw, *upper = map(float, words[first:])
        length = np.linalg.norm([qw, qx, qy, qz])
        matrix = pose(gtsam.Rot3.Quaternion(qw / length, qx / length, qy / length, qz / length).matrix(), [x, y, z])
        if upper:
            edges.append((int(words[1]), int(words[2]), matrix, d @ symmetric(upper) @ d))
        else:
            poses[int(words[1])] = matrix
    return edges, [poses[k] for k in sorted(poses)]


def residual(z_inverse, a, b):
    off = z_inverse @ np.linalg.inv(a) @ b
    return np.concatenate([off[:3, 3], gtsam.Rot3.Logmap(gtsam.Rot3(off[:3, :3]))]), off


def energy(edges, poses):
    total = 0.0
    for i, j, relative, weight in edges:
        r, _ = residual(np.linalg.inv(relative), poses[i], poses[j])
        total += r @ weight @ r
    return total


def inverse_right_jacobian(v):
    angle = np.linalg.norm(v)
    if angle < 1e-6:
        return np.eye(3) + 0.5 * hat(v)
    unit = hat(v) / angle
    return np.eye(3) + 0.5 * hat(v) + (1 - 0.5 * angle / np.tan(0.5 * angle)) * unit @ unit


def factor(i, j, relative, weight):
    z_inverse = np.linalg.inv(relative)

    def error(this, values, jacobians):
        a, b = (values.atPose3(key).matrix() for key in this.keys())
        r, off = residual(z_inverse, a, b)
        if jacobians is not None:
            # GTSAM disturbs poses on the right, rotation first.
            jr = inverse_right_jacobian(r[3:])
            a_from_b = np.linalg.inv(a) @ b
            by_a, by_b = np.zeros((6, 6)), np.zeros((6, 6))
            by_b[:3, 3:] = off[:3, :3]
            by_b[3:, :3] = jr
            by_a[:3, :3] = z_inverse[:3, :3] @ hat(a_from_b[:3, 3])
            by_a[:3, 3:] = -z_inverse[:3, :3]
            by_a[3:, :3] = -jr @ a_from_b[:3, :3].T
            jacobians[0], jacobians[1] = by_a, by_b
        return r

    return gtsam.CustomFactor(gtsam.noiseModel.Gaussian.Information(weight), [i, j], error)


def solve_by_gtsam(edges, chain):
    graph = gtsam.NonlinearFactorGraph()
    graph.add(gtsam.NonlinearEqualityPose3(0, gtsam.Pose3(chain[0])))
    for edge in edges:
        graph.add(factor(*edge))
    start = gtsam.Values()
    for k, matrix in enumerate(chain):
        start.insert(k, gtsam.Pose3(matrix))
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setMaxIterations(200)
    parameters.setRelativeErrorTol(1e-10)
    result = gtsam.LevenbergMarquardtOptimizer(graph, start, parameters).optimize()
    return [result.atPose3(k).matrix() for k in range(len(chain))]


class PublicSolver(unittest.TestCase):
    def compare(self, name, edges, chain, file=None):
        """Of a graph as it is in a g2o file, or to be written into one; returns the energy found."""
        with tempfile.TemporaryDirectory() as folder:
            graph, solved = file or pathlib.Path(folder, "in.g2o"), pathlib.Path(folder, "out.g2o")
            if not file:
                write_g2o(graph, edges, chain)
            started = time.monotonic()
            said = subprocess.run([SOLVE, graph, solved], check=True, capture_output=True, text=True).stdout.split()
            ours_s = time.monotonic() - started
            ours = energy(edges, read_g2o(solved)[1])
        theirs = energy(edges, solve_by_gtsam(edges, chain))
        print(f"{name}: {len(chain)} poses, {len(edges)} edges; energy at the start {energy(edges, chain):.6g}, "
              f"ours {ours:.9g} ({ours_s:.2f} s), GTSAM {theirs:.9g}, relative difference {ours / theirs - 1:.1e}",
              flush=True)
        self.assertEqual(said[1], "1", "converged")
        self.assertAlmostEqual(float(said[0]) / ours, 1, delta=1e-9, msg="the energy that the solver reports")
        self.assertAlmostEqual(ours / theirs, 1, delta=1e-4)
        return ours

    def compare_made(self, name, made, seed):
        edges, chain = measured(*made, seed)
        # An optimum explains the edges by their noise: about 6 for each edge beyond the tree's.
        self.assertLess(self.compare(name, edges, chain), 4 * 6 * (len(edges) - len(chain) + 1))

    def test_made_sphere(self):
        self.compare_made("made sphere", sphere(8 * SIZE, 25), 1)

    def test_made_torus(self):
        self.compare_made("made torus", torus(10 * SIZE, 20), 2)

    def test_made_grid(self):
        self.compare_made("made grid", grid(13 * SIZE, 0), 3)

    def test_sphere2500(self):
        edges, chain = read_toro(carried("sphere2500.txt"))
        self.assertEqual((len(chain), len(edges)), (2500, 4949))
        self.compare("sphere2500", edges, chain)

    def test_small_graphs_in_g2o_form(self):
        for name in ("pose3example.txt", "pose3example-grid.txt", "Klaus3.g2o"):
            with self.subTest(name):
                self.compare(name, *read_g2o(carried(name)), file=carried(name))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
