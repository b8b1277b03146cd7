#!/usr/bin/env python3
"""scripts/import_recording.py on recordings of Record3D made here: a room whose depth is known, packed by LZFSE itself.

    import_record3d_test.py SCRIPT DEEPSLAM

Exits with 77 (skipped) where lzfse, numpy or Pillow are missing.
"""
import importlib.metadata
import io
import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zipfile
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import python_packages  # noqa: E402

lzfse, numpy, PIL_Image = python_packages.need("lzfse", "numpy", "PIL.Image")

SCRIPT, PROGRAM = sys.argv.pop(1), sys.argv.pop(1)
sys.path.insert(0, str(pathlib.Path(SCRIPT).resolve().parent))
from record3d_recording import Damaged, Metadata, Reader, Refused  # noqa: E402

FRAMES, WIDTH, HEIGHT = 8, 72, 96
# fx fy cx cy of the first frame; each has its own, as phones focus.
CAMERA = (80.0, 80.5, 36.25, 47.5)
# The walls of the room, m: x, y, z of the far side of each axis, both ways.
WALLS = (1.5, 1.2, 2.0)


def camera_of(i):
    return CAMERA[0] + 0.5 * i, CAMERA[1] + 0.5 * i, CAMERA[2], CAMERA[3]


def turn_of(i):
    """Rotation of the camera (x right, y down, z forward) in the world: it pans and nods."""
    a, b = 0.05 * i, 0.03 * i
    pan = numpy.array([[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]])
    nod = numpy.array([[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]])
    return pan @ nod


def place_of(i):
    return numpy.array([0.04 * i, -0.02 * i, 0.03 * i])


def quaternion_of(m):
    w = math.sqrt(1 + m.trace()) / 2
    return [(m[2, 1] - m[1, 2]) / (4 * w), (m[0, 2] - m[2, 0]) / (4 * w), (m[1, 0] - m[0, 1]) / (4 * w), w]


def depth_of(i, size=(WIDTH, HEIGHT)):
    """m along the optical axis to the wall that each pixel of the frame sees."""
    sx, sy = size[0] / WIDTH, size[1] / HEIGHT
    fx, fy, cx, cy = camera_of(i)
    v, u = numpy.mgrid[0:size[1], 0:size[0]]
    rays = numpy.stack([((u + 0.5) / sx - 0.5 - cx) / fx, ((v + 0.5) / sy - 0.5 - cy) / fy, numpy.ones(u.shape)], -1) @ turn_of(i).T
    with numpy.errstate(divide="ignore"):
        along = numpy.where(rays > 0, (numpy.array(WALLS) - place_of(i)) / rays, (-numpy.array(WALLS) - place_of(i)) / rays)
    return along.min(-1).astype(numpy.float32)


def colour_of(i):
    depth = depth_of(i)
    grey = (127 + 120 * numpy.sin(40 * depth)).astype(numpy.uint8)
    data = io.BytesIO()
    PIL_Image.fromarray(numpy.stack([grey, grey // 2, 255 - grey], -1)).save(data, "JPEG", quality=95)
    return data.getvalue()


def metadata(**changed):
    turns = [quaternion_of(turn_of(i)) for i in range(FRAMES)]
    # ARKit's camera has y up and looks back along z: half a turn about x before.
    arkit = [[w, z, -y, -x] for x, y, z, w in turns]
    fields = {
        "w": WIDTH, "h": HEIGHT, "dw": WIDTH, "dh": HEIGHT, "fps": 60, "cameraType": 1, "initPose": [0, 0, 0, 1, 0, 0, 0],
        "K": [CAMERA[0], 0, 0, 0, CAMERA[1], 0, CAMERA[2], CAMERA[3], 1], "perFrameIntrinsicCoeffs": [list(camera_of(i)) for i in range(FRAMES)],
        "frameTimestamps": [i / 60 + 0.001 * (i % 2) for i in range(FRAMES)],
        "poses": [arkit[i] + place_of(i).tolist() for i in range(FRAMES)]}
    fields.update(changed)
    return json.dumps({k: v for k, v in fields.items() if v is not ...}).encode()


def recording(size=(WIDTH, HEIGHT), **changed):
    """Names and contents of a whole recording."""
    files = {"metadata": metadata(dw=size[0], dh=size[1], **changed), "icon": colour_of(0), "sound.m4a": b"music"}
    for i in range(FRAMES):
        sure = numpy.full((size[1], size[0]), 2, numpy.uint8)
        sure[0] = 0
        files[f"rgbd/{i}.jpg"] = colour_of(i)
        files[f"rgbd/{i}.depth"] = lzfse.compress(depth_of(i, size).tobytes())
        files[f"rgbd/{i}.conf"] = lzfse.compress(sure.tobytes())
    return files


def of_png(data):
    return numpy.asarray(PIL_Image.open(io.BytesIO(data)))


class ImportRecord3d(unittest.TestCase):
    def setUp(self):
        self.dir = pathlib.Path(tempfile.mkdtemp(prefix="deepslam-r3d-"))
        self.addCleanup(shutil.rmtree, self.dir, True)
        self.out = self.dir / "capture"

    def packed(self, files, name="room.r3d"):
        path = self.dir / name
        with zipfile.ZipFile(path, "w") as archive:
            for member, data in files.items():
                archive.writestr(member, data)
        return path

    def unpacked(self, files):
        for name, data in files.items():
            path = self.dir / "room" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        return self.dir / "room"

    def run_script(self, path, *options, **environment):
        shutil.rmtree(self.out, ignore_errors=True)
        return subprocess.run([sys.executable, SCRIPT, str(path), str(self.out), *options], capture_output=True, text=True, timeout=300,
                              env={**os.environ, **environment})

    def imports(self, path, *options):
        result = self.run_script(path, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stderr

    def refuses(self, path, *parts, options=(), **environment):
        result = self.run_script(path, *options, **environment)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertNotIn("Traceback", result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)
        self.assertEqual(sorted(p.name for p in self.dir.iterdir() if p.name.startswith(("capture", "."))), [], "nothing is left behind")

    def program(self, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=120)

    def read_back(self):
        """Depth in m, poses, times and camera as deepslam reads them: converted to layout tum."""
        tum = self.dir / "tum"
        shutil.rmtree(tum, ignore_errors=True)
        converted = self.program("convert", self.out, tum, "--to", "tum")
        self.assertEqual(converted.returncode, 0, converted.stderr)
        settings = (tum / "capture.yaml").read_text()
        units = float(re.search(r"depth_units_per_m: (\S+)", settings)[1])
        rows = [line.split() for line in (tum / "associations.txt").read_text().splitlines() if not line.startswith("#")]
        depth = [of_png((tum / next(f for f in row if f.startswith("depth/"))).read_bytes()) / units for row in rows]
        poses = tum / "groundtruth.txt"
        poses = [[float(x) for x in line.split()] for line in poses.read_text().splitlines() if line[0] != "#"] if poses.exists() else []
        camera = {k: float(x) for k, x in re.findall(r"\b(width|height|fx|fy|cx|cy): ([-\d.]+)", settings.split("depth_camera")[0])}
        return depth, poses, [float(row[0]) for row in rows], camera

    def check_capture(self):
        depth, poses, times, camera = self.read_back()
        self.assertEqual(len(depth), FRAMES)
        self.assertEqual([camera[k] for k in ("fx", "fy", "cx", "cy")], list(CAMERA))
        numpy.testing.assert_allclose(depth[0][1:], depth_of(0)[1:], atol=1e-3)
        self.assertFalse(depth[0][0].any(), "depth of low confidence is none")
        numpy.testing.assert_allclose(numpy.diff(times), numpy.diff([i / 60 + 0.001 * (i % 2) for i in range(FRAMES)]), atol=2e-6)
        for i, pose in enumerate(poses):
            numpy.testing.assert_allclose(pose[1:4], place_of(i), atol=1e-6)
            self.assertAlmostEqual(abs(numpy.dot(pose[4:], quaternion_of(turn_of(i)))), 1, places=6)
        self.assertEqual(len(poses), FRAMES)

    def test_an_archive_and_its_folder_are_read_as_they_were_recorded(self):
        files = recording()
        inner = {"room/" + name: data for name, data in files.items()}
        for path in (self.packed(files), self.unpacked(files), self.packed({**inner, "__MACOSX/room/._metadata": b"Mac"}, "room.zip")):
            with self.subTest(path=path.name):
                self.imports(path)
                self.check_capture()
                self.assertEqual((self.out / "rgb/3.jpg").read_bytes(), files["rgbd/3.jpg"])
                written = json.loads((self.out / "metadata.json").read_text())
                self.assertEqual(written, json.loads(files["metadata"]))
                numpy.testing.assert_allclose(of_png((self.out / "depth/5.png").read_bytes()) / 3000, depth_of(5), atol=2e-4)

    def test_cameras_of_single_frames_and_poses_hold_against_each_other(self):
        # Frames are brought to the first one's camera, and held against their neighbours through the poses.
        self.imports(self.packed(recording()))
        told = self.program("doctor", self.out)
        self.assertRegex(told.stderr, rf"ok +capture +layout record3d; {FRAMES} frames")
        self.assertNotIn("contradict", told.stderr)
        self.assertEqual(self.program("run", self.out, "-o", self.dir / "ws", "--until", "track", "--poses", "capture").returncode, 0)
        wrong = json.loads(metadata())
        for pose in wrong["poses"]:
            pose[:4] = [-pose[0], -pose[1], -pose[2], pose[3]]
        self.imports(self.packed({**recording(), "metadata": json.dumps(wrong).encode()}))
        self.assertIn("contradict", self.program("doctor", self.out).stderr)

    def test_coarse_depth_of_both_ways_of_holding_a_phone(self):
        self.imports(self.packed(recording(size=(18, 24))))
        depth = self.read_back()[0]
        self.assertEqual(depth[0].shape, (HEIGHT, WIDTH))
        # Between its pixels a wall is where it is; corners, and what has no four neighbours, are not.
        near = numpy.abs(depth[0] - depth_of(0)) < 1e-3
        self.assertGreater(near[8:-8, 8:-8].mean(), 0.9)
        files = recording()
        for name, data in files.items():
            if name.endswith(".jpg"):
                turned = io.BytesIO()
                PIL_Image.open(io.BytesIO(data)).transpose(PIL_Image.Transpose.ROTATE_90).save(turned, "JPEG")
                files[name] = turned.getvalue()
            if name.endswith(".depth"):
                files[name] = lzfse.compress(numpy.rot90(depth_of(int(name[5:-6]))).tobytes())
        k = [CAMERA[1], 0, 0, 0, CAMERA[0], 0, CAMERA[3], WIDTH - 1 - CAMERA[2], 1]
        files["metadata"] = metadata(w=HEIGHT, h=WIDTH, dw=HEIGHT, dh=WIDTH, K=k, perFrameIntrinsicCoeffs=...)
        self.imports(self.packed(files))
        numpy.testing.assert_allclose(self.read_back()[0][0][1:], numpy.rot90(depth_of(0))[1:], atol=1e-3)

    def test_old_recordings_without_sizes_times_and_confidence(self):
        files = {n: d for n, d in recording().items() if not n.endswith(".conf")}
        files["metadata"] = metadata(dw=..., dh=..., frameTimestamps=..., perFrameIntrinsicCoeffs=...)
        self.assertIn(f"{FRAMES} of {FRAMES} frames have no rgbd/N.conf", self.imports(self.packed(files)))
        depth, _, times, _ = self.read_back()
        numpy.testing.assert_allclose(depth[2], depth_of(2), atol=1e-3)
        numpy.testing.assert_allclose(numpy.diff(times), 1 / 60, atol=2e-6)

    def test_depth_that_is_no_number_is_none(self):
        files = recording()
        depth = depth_of(0)
        depth[5, :6] = [numpy.nan, numpy.inf, -numpy.inf, -1, 1e30, 25]
        files["rgbd/0.depth"] = lzfse.compress(depth.tobytes())
        self.imports(self.packed(files))
        self.assertFalse(of_png((self.out / "depth/0.png").read_bytes())[5, :6].any())
        numpy.testing.assert_allclose(self.read_back()[0][0][6:], depth[6:], atol=1e-3)

    def test_frames_that_are_not_whole_are_left_out_and_told(self):
        files = recording()
        files["rgbd/1.depth"] = files["rgbd/1.depth"][:-9]
        files["rgbd/2.jpg"] = files["rgbd/2.jpg"][:-40]
        del files["rgbd/6.depth"]
        told = self.imports(self.packed(files))
        for part in ("rgbd/1.depth: is cut at byte", "rgbd/2.jpg: is no whole JPEG", "rgbd/6: has no depth"):
            self.assertIn(part, told)
        self.assertEqual(sorted(p.stem for p in (self.out / "depth").iterdir()), ["0", "3", "4", "5", "7"])
        # What is left keeps its own pose and time.
        poses = self.read_back()[1]
        numpy.testing.assert_allclose(poses[1][1:4], place_of(3), atol=1e-6)
        self.assertIn("speaks of 8 frames", self.imports(self.packed({n: d for n, d in recording().items() if "/7." not in n})))

    def test_poses_of_some_frames_and_of_none(self):
        poses = json.loads(metadata())["poses"]
        told = self.imports(self.packed({**recording(), "metadata": metadata(poses=poses[:5])}))
        self.assertIn("'poses' has nothing readable for 3 of 8 frames", told)
        self.assertEqual(len(self.read_back()[1]), 5)
        self.imports(self.packed({**recording(), "metadata": metadata(poses=[[0, 0, 0, 1, 0, 0, 0]] * FRAMES)}))
        self.assertEqual(self.read_back()[1], [])
        self.assertIn("'poses' is the same for all frames", self.program("doctor", self.out).stderr)
        self.assertIn("8 of 8", self.imports(self.packed({**recording(), "metadata": metadata(poses=...)})))

    def test_what_the_metadata_says_wrongly_is_named(self):
        cases = {"w": (0, "many", True, [1], 1e9, 2.5, ...), "dw": (0, 30, {"a": 1}, 10**6), "K": (5, [1, 2], [[1, 0], [0, 1]], "K", ...),
                 "poses": (5, "none", {"0": []}), "perFrameIntrinsicCoeffs": (1, "x"), "frameTimestamps": (3, {}), "fps": ("fast", -1, [60])}
        for name, values in cases.items():
            for value in values:
                with self.subTest(name=name, value=value), self.assertRaisesRegex(Refused, rf"room.r3d: metadata.*'{name}'.*orrect"):
                    Metadata(metadata(**{name: value}), "room.r3d: metadata")
        for text, told in ((b"", "is not JSON"), (metadata()[:200], "is not JSON"), (b"[1]", "not a JSON object"), (b"[" * 100000, "is not JSON"),
                           (b"\xff\xfe\x00", "is not JSON")):
            with self.assertRaisesRegex(Refused, "room.r3d: metadata.*" + told):
                Metadata(text, "room.r3d: metadata")
        self.refuses(self.packed({**recording(), "metadata": metadata(poses=5)}), "room.r3d: metadata: field 'poses' is 5", "remove it")
        # What one reader of JSON takes and another does not.
        text = metadata(poses=...)[:-1] + b', "bias": NaN, "gain": 1e999, "poses": [[NaN, 0, 0, 1, 0, 0, 0]]}'
        self.imports(self.packed({**recording(), "metadata": text}))
        self.assertIsNone(json.loads((self.out / "metadata.json").read_text())["bias"])
        self.assertEqual(len(self.read_back()[0]), FRAMES)

    def test_what_a_later_version_may_add_is_kept(self):
        files = {**recording(), "metadata": metadata(version=9, lens={"k": [1, 2]}), "rgbd/0.heic": b"x", "audio/0": b"", "rgbd/extra/0.jpg": b""}
        self.imports(self.packed(files))
        self.check_capture()
        self.assertEqual(json.loads((self.out / "metadata.json").read_text())["lens"], {"k": [1, 2]})
        utf16 = json.dumps(json.loads(metadata())).encode("utf-16")
        self.imports(self.packed({**recording(), "metadata": utf16}))
        self.check_capture()

    def test_cut_and_damaged_archives(self):
        whole = self.packed(recording()).read_bytes()
        path = self.dir / "cut.r3d"
        for share in (0, 0.01, 0.5, 0.99):
            path.write_bytes(whole[:int(share * len(whole))])
            self.refuses(path, "cut.r3d", "copy it again")
        at = whole.index(b"rgbd/4.jpg") + 400
        path.write_bytes(whole[:at] + bytes(60) + whole[at + 60:])
        self.assertIn("rgbd/4.jpg: cannot be unpacked", self.imports(path))
        self.refuses(self.packed({"notes.txt": b"x"}), "has no 'metadata'", "unpacked")
        self.refuses(self.packed({"metadata": metadata()}), "has no 'rgbd/0.jpg'")

    def test_streams_that_lie_about_themselves(self):
        plain = depth_of(0).tobytes()
        head = struct.Struct("<4sI")
        for packed in (b"", b"bvx", b"bvx2" + bytes(20), b"bvx-" + struct.pack("<I", 2**32 - 1) + plain, b"bvxn" + b"\xff" * 40,
                       b"bvx2" + b"\xff" * 400, b"bvx9" + plain, b"bvx-" + bytes(8), lzfse.compress(plain[:-4]), lzfse.compress(plain + bytes(4)),
                       lzfse.compress(plain)[:-4], head.pack(b"bvx-", 0) * 3, plain[:-1], zlib.compress(plain)):
            with self.subTest(packed=packed[:12]):
                reader = Reader(self.packed({**recording(), "rgbd/0.depth": packed}))
                with self.assertRaisesRegex(Damaged, "^rgbd/0.depth: "):
                    reader.depth(0)
        self.refuses(self.packed({**recording(), **{f"rgbd/{i}.depth": b"bvx2" for i in range(5)}}), "5 of 8 frames cannot be used", "rgbd/0.depth")
        random = numpy.random.default_rng(5)
        files = recording()
        for i in range(FRAMES):
            packed = bytearray(files[f"rgbd/{i}.depth"])
            for at in random.integers(4, len(packed), 3):
                packed[at] ^= int(random.integers(1, 256))
            files[f"rgbd/{i}.depth"] = bytes(packed)
        result = self.run_script(self.packed(files))
        self.assertIn(result.returncode, (0, 3))
        self.assertNotIn("Traceback", result.stderr)

    def test_names_and_sizes_that_would_harm(self):
        files = {**recording(), "../outside.jpg": b"x", "rgbd/../../../outside.jpg": b"x", "/tmp/outside.depth": b"x", "rgbd/99999999999.jpg": b"x"}
        self.imports(self.packed(files))
        self.assertEqual(len(list((self.out / "rgb").iterdir())), FRAMES)
        self.assertFalse(list(self.dir.parent.glob("outside*")))
        # The directory of the archive says 3 GB of a file that has some bytes.
        data = bytearray(self.packed(recording()).read_bytes())
        at = data.rindex(b"rgbd/3.depth") - 46
        data[at + 24:at + 28] = struct.pack("<I", 3 << 30)
        path = self.dir / "large.r3d"
        path.write_bytes(data)
        self.assertIn("rgbd/3.depth: is said to hold 3221225472 bytes", self.imports(path))

    def test_images_of_another_size_than_stated(self):
        def larger(data, size):
            out = io.BytesIO()
            PIL_Image.open(io.BytesIO(data)).resize(size).save(out, "JPEG")
            return out.getvalue()
        files = recording()
        doubled = {n: larger(d, (2 * WIDTH, 2 * HEIGHT)) if n.endswith(".jpg") else d for n, d in files.items()}
        self.imports(self.packed(doubled))
        told = self.program("doctor", self.out).stderr
        self.assertIn("72 x 96 px, they have 144 x 192", told)
        self.assertRegex(told, "ok +capture")
        turned = {n: larger(d, (HEIGHT, WIDTH)) if n.endswith(".jpg") else d for n, d in files.items()}
        self.imports(self.packed(turned))
        self.assertIn("lies on its side", self.program("doctor", self.out).stderr)

    def test_the_package_is_missing(self):
        empty = self.dir / "path"
        empty.mkdir()
        for name in ("lzfse", "liblzfse"):
            (empty / f"{name}.py").write_text("raise ImportError('none', name=__name__)\n")
        self.refuses(self.packed(recording()), "package lzfse is missing", "import_requirements.txt", PYTHONPATH=str(empty))

    def test_what_is_said_to_whom_names_the_recording_to_the_program(self):
        for path in (self.packed(recording()), self.packed(recording(), "room.zip"), self.unpacked(recording())):
            told = self.program("doctor", path).stderr
            self.assertIn("Record3D", told)
            self.assertIn("scripts/import_recording.py", told)

    def test_the_package_is_the_one_that_users_are_told_to_install(self):
        pins = pathlib.Path(SCRIPT).with_name("import_requirements.txt").read_text()
        self.assertEqual(importlib.metadata.version("lzfse"), re.search(r"^lzfse==(\S+)$", pins, re.M)[1])

    def test_options(self):
        path = self.packed(recording())
        self.refuses(path, "--poses", "for bags", options=("--poses", "/vio"))
        self.imports(path, "--every", "3")
        self.assertEqual(sorted(p.stem for p in (self.out / "rgb").iterdir()), ["0", "3", "6"])
        numpy.testing.assert_allclose(self.read_back()[1][1][1:4], place_of(3), atol=1e-6)
        listed = subprocess.run([sys.executable, SCRIPT, str(path), "--list"], capture_output=True, text=True, timeout=60).stdout
        self.assertIn(f"{FRAMES} frames, colour {WIDTH} x {HEIGHT}", listed)
        self.assertIn("perFrameIntrinsicCoeffs", listed)


if __name__ == "__main__":
    unittest.main()
