#!/usr/bin/env python3
"""One capture in every layout, written here in plain Python by each layout's own description: equal frames give equal
trajectories; `convert` writes what these layouts say, and says what they cannot hold.

    formats_test.py DEEPSLAM REPOSITORY
"""
import json
import math
import pathlib
import resource
import shutil
import struct
import sys
import tempfile
import unittest
import zlib

import captures

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SKIPPED = 77
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-formats-")
DIR = pathlib.Path(TEMP.name)
ROOM = captures.make_room(PROGRAM, DIR / "room")
WIDTH, HEIGHT = 320, 240
F, CX, CY = 262.5, 159.5, 119.5


class Source:
    """The rendered room: depth in millimetres, colour made of it, poses as quaternions and matrices."""

    def __init__(self, folder):
        self.depth = [captures.read_grey16(file) for file in sorted((folder / "depth").iterdir())]
        self.colour = [[bytes(channel for u, d in enumerate(row) for channel in (d >> 4 & 255, (u * 3 + v) & 255, d & 255))
                        for v, row in enumerate(image)] for image in self.depth]
        self.poses = [list(map(float, line.split()[1:])) for line in (folder / "groundtruth.txt").read_text().splitlines()
                      if not line.startswith("#")]
        self.times_us = [round(i * 1e6 / 30) for i in range(len(self.depth))]

    def __len__(self):
        return len(self.depth)


SOURCE = Source(ROOM) if ROOM else None


def png(width, height, bits, kind, rows):
    file = DIR / "image.png"
    captures.write_png(file, width, height, bits, kind, rows)
    return file.read_bytes()


def depth_png(i, factor=1, nothing=0, extra=None):
    rows = []
    for v, row in enumerate(SOURCE.depth[i]):
        values = [nothing if d == 0 else d * factor + (extra(i, u, v) if extra else 0) for u, d in enumerate(row)]
        rows.append(struct.pack(f">{WIDTH}H", *values))
    return png(WIDTH, HEIGHT, 16, 0, rows)


COLOUR = {}


def colour_png(i):
    if i not in COLOUR:
        COLOUR[i] = png(WIDTH, HEIGHT, 8, 2, SOURCE.colour[i])
    return COLOUR[i]


def write(path, data):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())


def matrix(pose):
    x, y, z, qx, qy, qz, qw = pose
    n = math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw)
    qx, qy, qz, qw = qx / n, qy / n, qz / n, qw / n
    return [[1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw), x],
            [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw), y],
            [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy), z],
            [0, 0, 0, 1]]


def matrix_text(pose):
    return "".join(" ".join(f"{value:.12f}" for value in row) + "\n" for row in matrix(pose))


CAMERA = f"camera: {{width: {WIDTH}, height: {HEIGHT}, fx: {F}, fy: {F}, cx: {CX}, cy: {CY}}}\n"


def write_tum(folder, factor=1, extra=None):
    lists = {"rgb.txt": "# colour\n", "depth.txt": "# depth\n"}
    poses = ""
    for i in range(len(SOURCE)):
        time = f"{SOURCE.times_us[i] / 1e6:.6f}"
        write(folder / "rgb" / f"{time}.png", colour_png(i))
        write(folder / "depth" / f"{time}.png", depth_png(i, factor, extra=extra))
        lists["rgb.txt"] += f"{time} rgb/{time}.png\n"
        lists["depth.txt"] += f"{time} depth/{time}.png\n"
        poses += time + " " + " ".join(map(repr, SOURCE.poses[i])) + "\n"
    for name, text in lists.items():
        write(folder / name, text)
    write(folder / "groundtruth.txt", poses)
    write(folder / "capture.yaml", "format: tum\n" + CAMERA + f"depth_units_per_m: {1000 * factor}\n")
    return folder


def write_eth3d(folder):
    write_tum(folder, 5)
    (folder / "capture.yaml").unlink()
    write(folder / "calibration.txt", f"{F} {F} {CX} {CY}\n")
    return folder


def write_icl(folder):
    associations, poses = "", ""
    for i in range(len(SOURCE)):
        write(folder / "rgb" / f"{i}.png", colour_png(i))
        write(folder / "depth" / f"{i}.png", depth_png(i, 5))
        associations += f"{i} depth/{i}.png {i} rgb/{i}.png\n"
        x, y, z, qx, qy, qz, qw = SOURCE.poses[i]
        # The renderer's world has y the other way round.
        poses += f"{i} {x!r} {-y!r} {z!r} {-qx!r} {qy!r} {-qz!r} {qw!r}\n"
    write(folder / "associations.txt", associations)
    write(folder / "livingRoom0.gt.freiburg", poses)
    write(folder / "capture.yaml", "format: icl-nuim\n" + CAMERA)
    return folder


def write_seven_scenes(folder):
    for i in range(len(SOURCE)):
        write(folder / f"frame-{i:06d}.color.png", colour_png(i))
        write(folder / f"frame-{i:06d}.depth.png", depth_png(i, 1, 65535))
        write(folder / f"frame-{i:06d}.pose.txt", matrix_text(SOURCE.poses[i]))
    write(folder / "capture.yaml", CAMERA)
    return folder


def write_open3d(folder):
    log = ""
    for i in range(len(SOURCE)):
        write(folder / "color" / f"{i:05d}.png", colour_png(i))
        write(folder / "depth" / f"{i:05d}.png", depth_png(i))
        log += f"{i}\t{i}\t{i + 1}\n" + matrix_text(SOURCE.poses[i])
    write(folder / "camera_intrinsic.json", json.dumps(
        {"width": WIDTH, "height": HEIGHT, "intrinsic_matrix": [F, 0, 0, 0, F, 0, CX, CY, 1]}))
    write(folder / "trajectory.log", log)
    return folder


def floats(rows):
    return struct.pack("<16f", *[value for row in rows for value in row])


def write_sens(file, version=4):
    identity = [[float(r == c) for c in range(4)] for r in range(4)]
    k = [[F, 0, CX, 0], [0, F, CY, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    name = b"StructureSensor"
    out = struct.pack("<IQ", version, len(name)) + name
    out += floats(k) + floats(identity) + floats(k) + floats(identity)
    out += struct.pack("<iiIIIIfQ", 1, 1, WIDTH, HEIGHT, WIDTH, HEIGHT, 1000.0, len(SOURCE))
    for i in range(len(SOURCE)):
        colour = colour_png(i)
        depth = zlib.compress(b"".join(struct.pack(f"<{WIDTH}H", *row) for row in SOURCE.depth[i]))
        out += floats(matrix(SOURCE.poses[i]))
        out += struct.pack("<QQQQ", SOURCE.times_us[i], SOURCE.times_us[i], len(colour), len(depth)) + colour + depth
    if version == 4:
        out += struct.pack("<Q", 0)
    write(file, out)
    return file


def enlarged(rows, times):
    """Rows of RGB pixels, each of them `times` as wide and high."""
    wide = [b"".join(row[at:at + 3] * times for at in range(0, len(row), 3)) for row in rows]
    return [row for row in wide for _ in range(times)]


def write_stray(folder, larger=1):
    rows = "timestamp, frame, x, y, z, qx, qy, qz, qw\n"
    for i in range(len(SOURCE)):
        colour = colour_png(i) if larger == 1 else png(WIDTH * larger, HEIGHT * larger, 8, 2,
                                                       enlarged(SOURCE.colour[i], larger))
        write(folder / "rgb" / f"{i:06d}.png", colour)
        write(folder / "depth" / f"{i:06d}.png", depth_png(i))
        write(folder / "confidence" / f"{i:06d}.png", png(WIDTH, HEIGHT, 8, 0, [b"\2" * WIDTH] * HEIGHT))
        rows += f"{SOURCE.times_us[i] / 1e6:.6f}, {i:06d}, " + ", ".join(map(repr, SOURCE.poses[i])) + "\n"
    write(folder / "odometry.csv", rows)
    cx, cy = ((c + 0.5) * larger - 0.5 for c in (CX, CY))
    write(folder / "camera_matrix.csv", f"{F * larger}, 0.0, {cx}\n0.0, {F * larger}, {cy}\n0.0, 0.0, 1.0\n")
    return folder


def track(capture, *more):
    workspace = DIR / "workspace"
    shutil.rmtree(workspace, ignore_errors=True)
    result = captures.deepslam(PROGRAM, "run", capture, "-o", workspace, *captures.BARE, "--progress", "none",
                               "--until", "track", *more)
    assert result.returncode == 0, result.stderr
    return (workspace / "track" / "trajectory.tum").read_text()


def poses_of(text):
    return [list(map(float, line.split())) for line in text.splitlines() if line and not line.startswith("#")]


def convert(source, target, layout, *more, code=0):
    result = captures.deepslam(PROGRAM, "convert", source, target, "--to", layout, *more)
    assert result.returncode == code, result.stdout + result.stderr
    return result


def read_sens(file):
    """Header fields, and per frame (matrix, times, colour, depth bytes); the whole file must be used up."""
    data = file.read_bytes()
    version, length = struct.unpack_from("<IQ", data, 0)
    at = 12 + length
    matrices = [struct.unpack_from("<16f", data, at + 64 * n) for n in range(4)]
    at += 256
    fields = struct.unpack_from("<iiIIIIfQ", data, at)
    at += 36
    frames = []
    for _ in range(fields[7]):
        pose = struct.unpack_from("<16f", data, at)
        times = struct.unpack_from("<QQ", data, at + 64)
        sizes = struct.unpack_from("<QQ", data, at + 80)
        at += 96
        colour, depth = data[at:at + sizes[0]], data[at + sizes[0]:at + sum(sizes)]
        at += sum(sizes)
        frames.append((pose, times, colour, depth))
    if version == 4:
        assert struct.unpack_from("<Q", data, at)[0] == 0
        at += 8
    assert at == len(data), "bytes are left over"
    return version, matrices, fields, frames


class SameCapture(unittest.TestCase):
    def test_equal_frames_give_equal_trajectories(self):
        expected = track(write_tum(DIR / "tum"))
        self.assertEqual(len(poses_of(expected)), len(SOURCE))
        for name, capture in {"eth3d": write_eth3d(DIR / "eth3d"), "icl": write_icl(DIR / "icl"),
                              "7-scenes": write_seven_scenes(DIR / "seq-01"), "open3d": write_open3d(DIR / "open3d"),
                              "scannet": write_sens(DIR / "scene.sens"),
                              "scannet 3": write_sens(DIR / "scene3.sens", 3),
                              "stray": write_stray(DIR / "stray")}.items():
            with self.subTest(name):
                self.assertEqual(track(capture), expected, "trajectory, byte by byte")
                own = poses_of(track(capture, "--poses", "capture"))
                first = matrix(SOURCE.poses[0])
                for i, (time, *pose) in enumerate(own):
                    self.assertAlmostEqual(time, SOURCE.times_us[i] / 1e6, 6)
                    # Relative to the first frame, which is where the tracking world stands.
                    there = [SOURCE.poses[i][k] - SOURCE.poses[0][k] for k in range(3)]
                    local = [sum(first[r][c] * there[r] for r in range(3)) for c in range(3)]
                    for axis in range(3):
                        self.assertAlmostEqual(pose[axis], local[axis], 5)

    def test_boxes_of_larger_colour_images_are_scaled_to_the_frames(self):
        # Colour 1280 x 960 and depth 320 x 240: frames are 640 x 480.
        capture, workspace, file = write_stray(DIR / "fine", 4), DIR / "fine_boxes", DIR / "boxes.json"
        entry = {"image_id": 2, "bbox": [200, 100, 300, 400], "category_name": "chair"}
        named = {**entry, "image_id": 7}
        table = {"id": 7, "file_name": "000002.png"}
        for document, box in (([entry], [99.75, 49.75, 150, 200]),
                              ({"images": [{**table, "width": 1280, "height": 960}], "annotations": [named]},
                               [99.75, 49.75, 150, 200]),
                              ({"images": [{**table, "width": 640, "height": 480}], "annotations": [named]},
                               [200, 100, 300, 379])):
            file.write_text(json.dumps(document))
            result = captures.deepslam(PROGRAM, "run", capture, "-o", workspace, *captures.BARE, "--progress", "none", "--until",
                                       "detect", "--set", "detect.source=file", "--set", f"detect.file={file}", "--set",
                                       "detect.clusters.enabled=false")
            self.assertEqual(result.returncode, 0, result.stderr)
            found = json.loads((workspace / "detect" / "detections.json").read_text())
            self.assertEqual([row["bbox"] for row in found["annotations"]], [box])

    def test_doctor_and_eval_know_them(self):
        result = captures.deepslam(PROGRAM, "doctor", write_sens(DIR / "doctor.sens"))
        self.assertRegex(result.stderr, r"ok +capture +layout scannet; 10 frames of 320 x 240, with poses")
        write_seven_scenes(DIR / "doctor-seven")
        for truth in (DIR / "doctor.sens", DIR / "doctor-seven"):
            result = captures.deepslam(PROGRAM, "eval", "trajectory", truth, write_tum(DIR / "tum"))
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(json.loads(result.stdout)["num_scored"], len(SOURCE))

    def test_doctor_writes_a_capture_yaml_for_images_alone(self):
        folder = DIR / "images"
        for i in range(len(SOURCE)):
            write(folder / "rgb" / f"{i}.png", colour_png(i))
            write(folder / "depth" / f"{i}.png", depth_png(i))
        result = captures.deepslam(PROGRAM, "run", folder, "-o", DIR / "images_run", *captures.BARE, "--until", "track")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("--write-capture-yaml", result.stderr)
        told = captures.deepslam(PROGRAM, "doctor", folder, "--write-capture-yaml").stderr
        self.assertRegex(told, r"ok +capture.yaml +written to .*assumed: camera, depth_units_per_m")
        self.assertRegex(told, r"ok +capture +layout folders; 10 frames")
        self.assertIn("'camera' is assumed", told)
        written = (folder / "capture.yaml").read_text()
        told = captures.deepslam(PROGRAM, "doctor", folder, "--write-capture-yaml").stderr
        self.assertIn("not needed", told)
        self.assertEqual((folder / "capture.yaml").read_text(), written)
        # With the true camera in it the images are as good as any layout.
        write(folder / "capture.yaml", CAMERA + "depth_units_per_m: 1000\n")
        poses = zip(poses_of(track(folder)), poses_of(track(write_tum(DIR / "tum"))))
        self.assertTrue(all(a[1:] == b[1:] for a, b in poses))
        self.assertEqual(captures.deepslam(PROGRAM, "doctor", "--write-capture-yaml").returncode, 3)

    def test_poses_that_contradict_the_depth_are_refused(self):
        folder = write_tum(DIR / "misread")
        lines = [line.split() for line in (folder / "groundtruth.txt").read_text().splitlines()]
        write(folder / "groundtruth.txt", "\n".join(f"{t} {float(x) * 1000} {float(y) * 1000} {float(z) * 1000} {' '.join(q)}"
                                                   for t, x, y, z, *q in lines) + "\n")
        for poses in ("capture", "prior"):
            result = captures.deepslam(PROGRAM, "run", folder, "-o", DIR / "misread_run", *captures.BARE, "--until", "track",
                                       "--poses", poses)
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertRegex(result.stderr, "groundtruth.txt.*contradict the depth.*millimetres")
        self.assertEqual(track(folder), track(write_tum(DIR / "tum")), "tracking does not look at them")

    def test_other_depth_units_stay_within_a_millimetre(self):
        # Tenths of millimetres more than millimetres can say.
        fine = write_tum(DIR / "fine", 5, extra=lambda i, u, v: (3 * u + 5 * v + i) % 5 - 2)
        result = convert(fine, DIR / "fine-seven", "7scenes")
        self.assertIn("1/1000 m instead of 1/5000 m", result.stderr)
        self.assertIn("times: 7scenes has no place for them", result.stderr)
        for a, b in zip(poses_of(track(fine)), poses_of(track(DIR / "fine-seven"))):
            self.assertLess(math.dist(a[1:4], b[1:4]), 1e-3)


class Convert(unittest.TestCase):
    def setUp(self):
        if not (DIR / "tum").exists():
            write_tum(DIR / "tum")

    def test_sens_is_what_its_description_says(self):
        convert(DIR / "tum", DIR / "out.sens", "scannet")
        version, matrices, fields, frames = read_sens(DIR / "out.sens")
        self.assertEqual(version, 4)
        self.assertEqual(fields, (1, 1, WIDTH, HEIGHT, WIDTH, HEIGHT, 1000.0, len(SOURCE)))
        for k in (matrices[0], matrices[2]):
            self.assertEqual((k[0], k[5], k[2], k[6], k[15]), (F, F, CX, CY, 1.0))
        for i, (pose, times, colour, depth) in enumerate(frames):
            self.assertEqual(times, (SOURCE.times_us[i],) * 2)
            self.assertEqual(colour, colour_png(i), "colour bytes pass through")
            self.assertEqual(zlib.decompress(depth), b"".join(struct.pack(f"<{WIDTH}H", *r) for r in SOURCE.depth[i]))
            for value, true in zip(pose, [v for row in matrix(SOURCE.poses[i]) for v in row]):
                self.assertAlmostEqual(value, true, 5)

    def test_open3d_is_what_its_description_says(self):
        convert(DIR / "tum", DIR / "out-open3d", "open3d")
        intrinsics = json.loads((DIR / "out-open3d" / "camera_intrinsic.json").read_text())
        self.assertEqual(intrinsics["intrinsic_matrix"], [F, 0, 0, 0, F, 0, CX, CY, 1])
        depth = sorted((DIR / "out-open3d" / "depth").iterdir())
        colour = sorted((DIR / "out-open3d" / "color").iterdir())
        self.assertEqual(len(depth), len(SOURCE))
        for i in (0, len(SOURCE) - 1):
            self.assertEqual([list(row) for row in captures.read_grey16(depth[i])], [list(r) for r in SOURCE.depth[i]])
            self.assertEqual(colour[i].read_bytes(), colour_png(i))
        lines = (DIR / "out-open3d" / "trajectory.log").read_text().splitlines()
        self.assertEqual(len(lines), 5 * len(SOURCE))
        for i in range(len(SOURCE)):
            self.assertEqual(lines[5 * i].split()[0], str(i))
            for row, true in zip(lines[5 * i + 1:5 * i + 5], matrix(SOURCE.poses[i])):
                for value, expected in zip(map(float, row.split()), true):
                    self.assertAlmostEqual(value, expected, 9)

    def test_seven_scenes_is_what_its_description_says(self):
        convert(DIR / "tum", DIR / "out-seven", "7scenes")
        for i in (0, len(SOURCE) - 1):
            rows = captures.read_grey16(DIR / "out-seven" / f"frame-{i:06d}.depth.png")
            self.assertEqual([list(row) for row in rows], [[d or 65535 for d in r] for r in SOURCE.depth[i]])
            self.assertEqual((DIR / "out-seven" / f"frame-{i:06d}.color.png").read_bytes(), colour_png(i))
            rows = (DIR / "out-seven" / f"frame-{i:06d}.pose.txt").read_text().splitlines()
            for row, true in zip(rows, matrix(SOURCE.poses[i])):
                for value, expected in zip(map(float, row.split()), true):
                    self.assertAlmostEqual(value, expected, 9)

    def test_round_trips_track_alike(self):
        expected = track(DIR / "tum")
        convert(DIR / "tum", DIR / "round.sens", "scannet")
        result = convert(DIR / "round.sens", DIR / "round-tum", "tum")
        report = json.loads(result.stdout)
        self.assertEqual(report["num_frames"], len(SOURCE))
        self.assertEqual(report, json.loads((DIR / "round-tum" / "conversion.json").read_text()))
        self.assertEqual(track(DIR / "round-tum"), expected)

    def test_a_tracked_capture_is_trained_on_elsewhere(self):
        track(DIR / "tum")
        poses = {row[0]: row[1:4] for row in poses_of((DIR / "workspace" / "track" / "trajectory.tum").read_text())}
        convert(DIR / "tum", DIR / "nerfstudio", "nerfstudio", "--trajectory", DIR / "workspace")
        frames = json.loads((DIR / "nerfstudio" / "transforms.json").read_text())["frames"]
        for frame, (_, true) in zip(frames, sorted(poses.items())):
            for row, value in zip(frame["transform_matrix"], true):
                self.assertAlmostEqual(row[3], value, 6)
        convert(DIR / "tum", DIR / "colmap", "colmap", "--trajectory", DIR / "workspace" / "track" / "trajectory.tum")
        names = (DIR / "colmap" / "sparse" / "0" / "images.txt").read_text()
        self.assertEqual(names.count("frame_"), len(SOURCE))
        convert(DIR / "tum", DIR / "none", "colmap", "--trajectory", DIR / "nowhere", code=3)

    def test_wrong_use_and_bad_input(self):
        result = convert(DIR / "tum", DIR / "x", "rosbag", code=2)
        self.assertIn("rosbag", result.stderr)
        convert(DIR / "tum", DIR / "tum", "tum", code=2)
        convert(DIR / "tum", DIR / "folder", "scannet", code=2)
        convert(DIR / "nowhere", DIR / "x", "tum", code=3)
        self.assertFalse((DIR / "x").exists())

    def test_sens_of_lies_needs_no_memory(self):
        good = write_sens(DIR / "lie.sens").read_bytes()
        at = 12 + 15 + 256 + 8
        lies = {"frames": good[:at + 20] + struct.pack("<Q", 1 << 60) + good[at + 28:],
                "sizes": good[:at] + struct.pack("<IIII", 16384, 16384, 16384, 16384) + good[at + 16:],
                "colour": good[:at + 28 + 80] + struct.pack("<Q", 1 << 62) + good[at + 28 + 88:]}

        def limit():
            resource.setrlimit(resource.RLIMIT_DATA, (400 << 20, 400 << 20))
        # An instrumented program cannot start under that limit; it has one of its own, for one allocation.
        plain = captures.deepslam(PROGRAM, "--version", preexec_fn=limit).returncode == 0
        limits = {"preexec_fn": limit} if plain else {"variables": {"ASAN_OPTIONS": "max_allocation_size_mb=400"}}
        for name, data in lies.items():
            with self.subTest(name):
                write(DIR / "lie.sens", data)
                result = captures.deepslam(PROGRAM, "run", DIR / "lie.sens", "-o", DIR / "lie", *captures.BARE,
                                           **limits)
                self.assertEqual(result.returncode, 3, result.stderr)
                self.assertIn("lie.sens", result.stderr)
                self.assertFalse((DIR / "lie").exists())


if __name__ == "__main__":
    if ROOM is None:
        print("furniture catalogues are not installed", file=sys.stderr)
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1], verbosity=2)
