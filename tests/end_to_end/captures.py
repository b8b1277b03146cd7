"""Captures and runs for the end-to-end tests: the program as a user meets it, python3 alone."""
import json
import os
import pathlib
import shutil
import struct
import subprocess
import zlib

SCENE = """seed: 7
frames: 10
frames_per_s: 15
depth_units_per_m: 1000
camera: {width: 320, height: 240, fx: 262.5, fy: 262.5, cx: 159.5, cy: 119.5}
room: {size_m: [6.2, 6.0, 2.6], floor: wood, wall_colour_rgb: [206, 196, 178], posters: 6, ambient: 0.4}
lights:
  - {position_m: [0.6, 0.4, 2.55], side_m: 0.9, power: 2.4}
objects:
  - {class: table, model: "Blend Swap CC-BY#table", position_m: [0.0, 0.0], yaw_deg: 0}
  - {class: chair, model: "Blend Swap CC-BY#chairWithCushion", position_m: [0.95, 0.35], yaw_deg: 195}
  - {class: chair, model: "Scopia#chair", position_m: [0.15, -1.05], yaw_deg: 80}
orbit: {centre_m: [0.0, -0.1], radius_m: 2.5, height_m: 1.6, target_height_m: 0.45, start_deg: -160, sweep_deg: 25,
        shake_m: 0.005, shake_deg: 0.2}
# The noise of a 640 pixel wide sensor on half the pixels would be twice that of any real one.
faults: {depth_noise: false, depth_holes: true, colour_noise: true}
"""
# Neither weights nor furniture library.
BARE = ("--set", "detect.source=none", "--set", "propose.retrieval=false")


def deepslam(program, *arguments, data="/nonexistent", timeout=600, variables=None, **options):
    environment = dict(os.environ, **(variables or {}))
    if data is not None:
        environment["DEEPSLAM_DATA"] = str(data)
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, errors="replace",
                          timeout=timeout, env=environment, **options)


def make_room(program, folder):
    """A table and two chairs in ten frames. None where the furniture catalogues are not installed."""
    return render(program, SCENE, folder)


def render(program, text, folder):
    """The capture of a scene's YAML. None where the furniture catalogues are not installed."""
    scene = folder.with_suffix(".yaml")
    scene.write_text(text)
    made = deepslam(program, "synth", scene, "-o", folder)
    if made.returncode == 3 and "sweethome3d-furniture" in made.stderr:
        return None
    assert made.returncode == 0, made.stderr
    return folder


def copy_capture(source, target, frames=None, first=0):
    """The same capture by links to its images, cut to frames first .. frames - 1; lists and settings are copies."""
    for kind in ("rgb", "depth"):
        (target / kind).mkdir(parents=True)
        for file in sorted((source / kind).iterdir()):
            (target / kind / file.name).symlink_to(file.resolve())
    for name in ("capture.yaml", "groundtruth.txt"):
        shutil.copy(source / name, target / name)
    for name in ("associations.txt", "rgb.txt", "depth.txt"):
        lines = [line for line in (source / name).read_text().splitlines() if not line.startswith("#")]
        (target / name).write_text("\n".join(lines[first:frames]) + "\n")
    return target


def concatenate(first, second, target):
    """Both captures in one, as if the recorder had been carried elsewhere: without poses, in the first one's time."""
    copy_capture(first, target)
    (target / "groundtruth.txt").unlink()
    for kind in ("rgb", "depth"):
        for file in sorted((second / kind).iterdir()):
            (target / kind / f"second_{file.name}").symlink_to(file.resolve())
    for name, times in (("associations.txt", (0, 2)), ("rgb.txt", (0,)), ("depth.txt", (0,))):
        own = (target / name).read_text().splitlines()
        after = float(own[-1].split()[0]) + 0.07
        for line in (second / name).read_text().splitlines():
            if line.startswith("#"):
                continue
            words = line.split()
            shifted = [f"{float(word) + after:.6f}" if k in times else word.replace("/", "/second_")
                       for k, word in enumerate(words)]
            own.append(" ".join(shifted))
        (target / name).write_text("\n".join(own) + "\n")
    return target


def write_png(path, width, height, bit_depth, colour_type, rows):
    """PNG of unfiltered rows; colour_type 0 grey, 2 RGB."""
    def chunk(kind, payload):
        return struct.pack(">I", len(payload)) + kind + payload + struct.pack(">I", zlib.crc32(kind + payload))
    header = struct.pack(">IIBBBBB", width, height, bit_depth, colour_type, 0, 0, 0)
    raw = zlib.compress(b"".join(b"\0" + row for row in rows), 1)
    replace(path, b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", raw) + chunk(b"IEND", b""))


def write_depth(path, width, height, value):
    """A 16-bit depth image of one value."""
    write_png(path, width, height, 16, 0, [struct.pack(">H", value) * width] * height)


def replace(path, data):
    """Writes a file, never through a link into another capture."""
    path = pathlib.Path(path)
    path.unlink(missing_ok=True)
    path.write_bytes(data)


def read_grey16(path):
    """Rows of a 16-bit grey PNG, as lists of numbers."""
    data = pathlib.Path(path).read_bytes()
    at, compressed, width, height = 8, b"", 0, 0
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        payload = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", payload[:8])
            assert payload[8:10] == b"\x10\0", "16-bit grey"
        elif kind == b"IDAT":
            compressed += payload
        at += 12 + length
    raw, stride, rows, above = zlib.decompress(compressed), 2 * width, [], bytearray(2 * width)
    for v in range(height):
        begin = v * (stride + 1)
        row = unfilter(raw[begin], bytearray(raw[begin + 1:begin + 1 + stride]), above)
        rows.append(struct.unpack(f">{width}H", row))
        above = row
    return rows


def unfilter(kind, row, above):
    for i in range(len(row)):
        left = row[i - 2] if i >= 2 else 0
        corner = above[i - 2] if i >= 2 else 0
        if kind == 1:
            row[i] = (row[i] + left) & 255
        elif kind == 2:
            row[i] = (row[i] + above[i]) & 255
        elif kind == 3:
            row[i] = (row[i] + (left + above[i]) // 2) & 255
        elif kind == 4:
            guess = left + above[i] - corner
            nearest = min((abs(guess - left), 0, left), (abs(guess - above[i]), 1, above[i]),
                          (abs(guess - corner), 2, corner))
            row[i] = (row[i] + nearest[2]) & 255
    return row


def read_poses(file):
    """World from camera, (x y z, quaternion x y z w), of a TUM trajectory."""
    rows = [line.split() for line in pathlib.Path(file).read_text().splitlines() if not line.startswith("#")]
    return [[float(word) for word in row[1:]] for row in rows]


def apply(pose, point):
    """The point moved by a pose as read_poses gives it."""
    x, y, z, w = pose[3:]
    turn = ((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))
    return [pose[row] + sum(turn[row][k] * point[k] for k in range(3)) for row in range(3)]


def true_boxes(capture):
    """COCO results of the rendered objects: the boxes of their true masks."""
    objects = json.loads((capture / "truth" / "objects.json").read_text())["objects"]
    results = []
    for frame, file in enumerate(sorted((capture / "truth" / "instances").iterdir())):
        boxes = {}
        for v, row in enumerate(read_grey16(file)):
            for instance in set(row):
                if not 0 < instance <= len(objects):
                    continue
                first = row.index(instance)
                last = len(row) - 1 - row[::-1].index(instance)
                u0, v0, u1, _ = boxes.get(instance, (first, v, last, v))
                boxes[instance] = (min(u0, first), v0, max(u1, last), v)
        for instance, (u0, v0, u1, v1) in sorted(boxes.items()):
            if (u1 - u0) * (v1 - v0) > 200:
                results.append({"image_id": frame, "category_name": objects[instance - 1]["class"], "score": 0.9,
                                "bbox": [u0, v0, u1 - u0 + 1, v1 - v0 + 1]})
    return results
