#!/usr/bin/env python3
"""scripts/import_recording.py on recordings that rosbags writes, and on Matroska files written here.

    import_recording_test.py SCRIPT DEEPSLAM

Exits with 77 (skipped) where rosbags, mcap or numpy are missing.
"""
import importlib.metadata
import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import python_packages  # noqa: E402

mcap, numpy, _ = python_packages.need("mcap", "numpy", "rosbags")
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import StoragePlugin, Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

SCRIPT, PROGRAM = sys.argv.pop(1), sys.argv.pop(1)
WIDTH, HEIGHT, FRAMES = 32, 24, 4
STORE = {1: get_typestore(Stores.ROS1_NOETIC), 2: get_typestore(Stores.ROS2_HUMBLE)}


def depth_mm(i):
    v, u = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    return (1000 + 10 * i + 3 * u + v).astype(numpy.uint16)


def colour(i):
    v, u = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    return numpy.stack([20 * i + u, 3 * v, numpy.full_like(u, 200 - i)], -1).astype(numpy.uint8)


def read_png(data):
    """Pixels of a PNG that is not filtered, as the script writes them."""
    at, parts, head = 8, b"", None
    while at < len(data):
        length, name = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        head = struct.unpack(">IIBB", body[:10]) if name == b"IHDR" else head
        parts += body if name == b"IDAT" else b""
        at += 12 + length
    width, height, bits, kind = head
    rows = numpy.frombuffer(zlib.decompress(parts), numpy.uint8).reshape(height, -1)
    assert not rows[:, 0].any()
    pixels = numpy.ascontiguousarray(rows[:, 1:])
    if bits == 16:
        return pixels.view(">u2").astype(numpy.uint16)
    return pixels.reshape(height, width, 3) if kind == 2 else pixels


class Recording:
    """Messages of ROS 1 or 2 by one set of calls."""

    def __init__(self, path, version, plugin=None):
        self.version, self.store, self.connections = version, STORE[version], {}
        self.types = self.store.types
        self.writer = Writer1(path) if version == 1 else Writer2(path, version=9, storage_plugin=plugin or StoragePlugin.SQLITE3)

    def __enter__(self):
        self.writer.open()
        return self

    def __exit__(self, *_):
        self.writer.close()

    def header(self, time_s, frame):
        stamp = self.types["builtin_interfaces/msg/Time"](sec=int(time_s), nanosec=int(round((time_s % 1) * 1e9)))
        extra = {"seq": 0} if self.version == 1 else {}
        return self.types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **extra)

    def put(self, topic, time_s, message):
        kind = message.__msgtype__
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        raw = self.store.serialize_ros1(message, kind) if self.version == 1 else self.store.serialize_cdr(message, kind)
        self.writer.write(self.connections[topic], int(time_s * 1e9), raw)

    def image(self, topic, time_s, pixels, encoding, frame="camera_color_optical_frame"):
        data = numpy.ascontiguousarray(pixels)
        raw = data.view(numpy.uint8).reshape(-1)
        self.put(topic, time_s, self.types["sensor_msgs/msg/Image"](
            header=self.header(time_s, frame), height=data.shape[0], width=data.shape[1], encoding=encoding, is_bigendian=0,
            step=raw.size // data.shape[0], data=raw))

    def info(self, topic, time_s, fx, lens=(), model="plumb_bob", frame="camera_color_optical_frame"):
        letters = ("D", "K", "R", "P") if self.version == 1 else ("d", "k", "r", "p")
        roi = self.types["sensor_msgs/msg/RegionOfInterest"](x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        values = (numpy.array(lens, float), numpy.array([fx, 0, 15.5, 0, fx, 11.25, 0, 0, 1.0]), numpy.eye(3).reshape(-1), numpy.zeros(12))
        self.put(topic, time_s, self.types["sensor_msgs/msg/CameraInfo"](
            header=self.header(time_s, frame), height=HEIGHT, width=WIDTH, distortion_model=model, binning_x=0, binning_y=0, roi=roi,
            **dict(zip(letters, values))))

    def transform(self, shift, turn):
        vector = self.types["geometry_msgs/msg/Vector3"](*shift)
        quaternion = self.types["geometry_msgs/msg/Quaternion"](*turn)
        return self.types["geometry_msgs/msg/Transform"](translation=vector, rotation=quaternion)

    def tf_static(self, time_s, parent, child, shift, turn=(0, 0, 0, 1)):
        stamped = self.types["geometry_msgs/msg/TransformStamped"](
            header=self.header(time_s, parent), child_frame_id=child, transform=self.transform(shift, turn))
        self.put("/tf_static", time_s, self.types["tf2_msgs/msg/TFMessage"](transforms=[stamped]))

    def pose(self, topic, time_s, shift, turn=(0, 0, 0, 1)):
        pose = self.types["geometry_msgs/msg/Pose"](
            position=self.types["geometry_msgs/msg/Point"](*shift), orientation=self.types["geometry_msgs/msg/Quaternion"](*turn))
        self.put(topic, time_s, self.types["geometry_msgs/msg/PoseStamped"](header=self.header(time_s, "world"), pose=pose))


def write_usual(recording, registered=True, lens=(0.1, -0.2, 0.001, 0.002, 0.05)):
    depth = "/camera/aligned_depth_to_color/image_raw" if registered else "/camera/depth/image_rect_raw"
    frame = "camera_color_optical_frame" if registered else "camera_depth_optical_frame"
    for i in range(FRAMES):
        t = 1700000000 + 0.1 * i
        recording.image("/camera/color/image_raw", t, colour(i), "rgb8")
        recording.image(depth, t + 0.004, depth_mm(i), "16UC1", frame)
        recording.info("/camera/color/camera_info", t, 30.5, lens)
        recording.info(depth.rsplit("/", 1)[0] + "/camera_info", t, 30.5 if registered else 28.5, lens if registered else (), frame=frame)
        recording.pose("/vio/pose", t, (0.1 * i, 0, 0))
    if not registered:
        recording.tf_static(1700000000, "camera_link", "camera_depth_optical_frame", (0, 0, 0), (-0.5, 0.5, -0.5, 0.5))
        recording.tf_static(1700000000, "camera_link", "camera_color_optical_frame", (0, 0.015, 0), (-0.5, 0.5, -0.5, 0.5))


# --- Matroska, as Azure Kinect's recorder writes it

def element(kind, payload):
    return bytes.fromhex(kind) + (len(payload) | 1 << 56).to_bytes(8, "big") + payload


def track(number, name, size, code):
    private = struct.pack("<IiiHH4sIiiII", 40, size[0], size[1], 1, 16, code, 0, 0, 0, 0, 0)
    return element("AE", element("D7", bytes([number])) + element("536E", name.encode()) + element("63A2", private))


def azure_camera(location, fx, shift):
    parameters = [0.5, 0.5, fx, fx, 0.3, -0.2, 0.05, 0.6, -0.1, 0.02, 0, 0, 0.0001, -0.0002]
    return {"Location": "CALIBRATION_CameraLocation" + location, "Intrinsics": {"ModelParameters": parameters},
            "Rt": {"Rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "Translation": shift}}


def azure(jpeg, depth, calibration=True):
    cameras = {"CalibrationInformation": {"Cameras": [azure_camera("D0", 0.5, [0, 0, 0]), azure_camera("PV0", 0.48, [-0.032, -0.002, 0.004])]}}
    attached = element("466E", b"calibration.json") + element("465C", json.dumps(cameras).encode() + b"\0")
    clusters = b""
    for i in range(FRAMES):
        block = struct.pack(">h", 5) + b"\x80"
        clusters += element("1F43B675", element("E7", (33 * i).to_bytes(2, "big")) + element("A3", b"\x81" + block + jpeg) +
                            element("A0", element("A1", b"\x82" + block + depth[i].astype(">u2").tobytes())))
    body = element("1549A966", element("2AD7B1", (1000000).to_bytes(3, "big")))
    body += element("1654AE6B", track(1, "COLOR", (1280, 720), b"MJPG") + track(2, "DEPTH", (320, 288), b"b16g"))
    body += element("1941A469", element("61A7", attached)) if calibration else b""
    return element("1A45DFA3", b"") + element("18538067", body + clusters)


class Import(unittest.TestCase):
    def setUp(self):
        self.dir = pathlib.Path(tempfile.mkdtemp(prefix="deepslam-import-"))
        self.addCleanup(shutil.rmtree, self.dir, True)
        self.out = self.dir / "capture"

    def run_script(self, recording, *options, folder=True):
        return subprocess.run([sys.executable, SCRIPT, str(recording), *([str(self.out)] if folder else []), *options],
                              capture_output=True, text=True, timeout=300)

    def imports(self, recording, *options):
        result = self.run_script(recording, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def refuses(self, recording, *parts, options=()):
        result = self.run_script(recording, *options)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertNotIn("Traceback", result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)
        self.assertFalse(self.out.exists(), "nothing is left behind")
        self.assertEqual([p.name for p in self.dir.iterdir() if p.name.startswith(".")], [])

    def check_frames(self):
        names = [line.split()[1] for line in (self.out / "depth.txt").read_text().splitlines()[1:]]
        self.assertEqual(len(names), FRAMES)
        for i, name in enumerate(names):
            numpy.testing.assert_array_equal(read_png((self.out / name).read_bytes()), depth_mm(i))
        names = [line.split()[1] for line in (self.out / "rgb.txt").read_text().splitlines()[1:]]
        for i, name in enumerate(names):
            numpy.testing.assert_array_equal(read_png((self.out / name).read_bytes()), colour(i))
        self.assertEqual(float((self.out / "rgb.txt").read_text().splitlines()[1].split()[0]), 1700000000)

    def check_deepslam_reads_it(self):
        told = subprocess.run([PROGRAM, "doctor", str(self.out)], capture_output=True, text=True, timeout=120).stderr
        self.assertRegex(told, rf"ok +capture +layout tum; {FRAMES} frames")

    def recordings(self, fill):
        with Recording(self.dir / "one.bag", 1) as one:
            fill(one)
        with Recording(self.dir / "two", 2) as two:
            fill(two)
        with Recording(self.dir / "three", 2, StoragePlugin.MCAP) as three:
            fill(three)
        return [self.dir / "one.bag", self.dir / "two", next((self.dir / "three").glob("*.mcap"))]

    def test_every_kind_of_bag_becomes_the_same_capture(self):
        for recording in self.recordings(write_usual):
            with self.subTest(recording=recording.name):
                self.imports(recording)
                self.check_frames()
                settings = (self.out / "capture.yaml").read_text()
                self.assertIn("fx: 30.5", settings)
                self.assertIn("model: radial-tangential, coefficients: [0.1, -0.2, 0.001, 0.002, 0.05]", settings)
                self.assertNotIn("depth_camera", settings)
                self.assertFalse((self.out / "groundtruth.txt").exists())
                self.check_deepslam_reads_it()
                shutil.rmtree(self.out)

    def test_depth_beside_colour_keeps_its_camera_and_place(self):
        with Recording(self.dir / "beside", 2) as recording:  # the messages of tf2 are not among those that rosbags has for ROS 1
            write_usual(recording, registered=False, lens=())
        self.imports(self.dir / "beside")
        settings = (self.out / "capture.yaml").read_text()
        self.assertRegex(settings, r"depth_camera: \{width: 32, height: 24, fx: 28.5")
        shift = [float(x) for x in re.search(r"translation_m: \[([^]]*)\]", settings).group(1).split(",")]
        # Colour sits 15 mm to the left of depth: what depth sees lies 15 mm further right in colour.
        numpy.testing.assert_allclose(shift, [0.015, 0, 0], atol=1e-9)
        self.check_deepslam_reads_it()

    def test_poses_are_taken_where_they_are_named(self):
        recording = self.recordings(write_usual)[1]
        self.imports(recording, "--poses", "/vio/pose")
        rows = [[float(x) for x in line.split()] for line in (self.out / "groundtruth.txt").read_text().splitlines()[1:]]
        numpy.testing.assert_allclose([row[1] for row in rows], [0, 0.1, 0.2, 0.3], atol=1e-9)
        shutil.rmtree(self.out)
        self.refuses(recording, "/nowhere", "/vio/pose", options=("--poses", "/nowhere"))

    def test_realsense_viewers_topics(self):
        path = self.dir / "viewer.bag"
        with Recording(path, 1) as bag:
            for sensor, name in ((0, "Depth_0"), (1, "Color_0")):
                stem = f"/device_0/sensor_{sensor}/{name}"
                bag.info(stem + "/info/camera_info", 1, 30.5, model="")
                bag.put(stem + "/tf/0", 1, bag.transform((0.015 * sensor, 0, 0), (0, 0, 0, 1)))
            bag.put("/device_0/sensor_0/option/Depth Units/value", 1, bag.types["std_msgs/msg/Float32"](data=0.00025))
            for i in range(FRAMES):
                bag.image("/device_0/sensor_1/Color_0/image/data", 1 + 0.1 * i, colour(i), "rgb8")
                bag.image("/device_0/sensor_0/Depth_0/image/data", 1 + 0.1 * i, depth_mm(i), "mono16")
                bag.image("/device_0/sensor_0/Infrared_1/image/data", 1 + 0.1 * i, depth_mm(i).astype(numpy.uint8), "mono8")
        self.imports(path)
        settings = (self.out / "capture.yaml").read_text()
        self.assertRegex(settings, r"depth_units_per_m: 4000\n")
        self.assertIn("translation_m: [-0.015, 0, 0]", settings)

    def test_depth_as_real_numbers_and_other_orders_of_colour(self):
        path = self.dir / "real.bag"
        with Recording(path, 1) as bag:
            bag.info("/rgb/camera_info", 1, 30.5)
            bag.info("/depth/camera_info", 1, 30.5)
            for i in range(FRAMES):
                bag.image("/rgb/image", 1 + 0.1 * i, colour(i)[..., ::-1], "bgr8")
                metres = (depth_mm(i) / 1000).astype(numpy.float32)
                metres[0, 0], metres[0, 1] = numpy.nan, numpy.inf
                bag.image("/depth/image", 1 + 0.1 * i, metres, "32FC1")
        self.imports(path)
        names = [line.split()[1] for line in (self.out / "depth.txt").read_text().splitlines()[1:]]
        pixels = read_png((self.out / names[1]).read_bytes())
        self.assertEqual((pixels[0, 0], pixels[0, 1]), (0, 0))
        numpy.testing.assert_allclose(pixels[1:] / 5000, depth_mm(1)[1:] / 1000, atol=1.1e-4)
        names = [line.split()[1] for line in (self.out / "rgb.txt").read_text().splitlines()[1:]]
        numpy.testing.assert_array_equal(read_png((self.out / names[2]).read_bytes()), colour(2))

    def test_what_cannot_be_decided_is_listed(self):
        path = self.dir / "two_cameras.bag"
        with Recording(path, 1) as bag:
            write_usual(bag)
            bag.image("/wrist/color/image_raw", 1700000000, colour(0), "rgb8")
        self.refuses(path, "several topics may be colour", "--colour", "/wrist/color/image_raw", "/camera/color/image_raw")
        self.imports(path, "--colour", "/camera/color/image_raw")
        self.check_frames()
        listed = self.run_script(path, "--list", folder=False)
        self.assertIn("/wrist/color/image_raw  sensor_msgs/msg/Image  1", listed.stdout)

    def test_what_is_missing_is_said(self):
        path = self.dir / "no_info.bag"
        with Recording(path, 1) as bag:
            bag.image("/rgb/image", 1, colour(0), "rgb8")
            bag.image("/depth/image", 1, depth_mm(0), "16UC1")
        self.refuses(path, "CameraInfo")
        path = self.dir / "no_depth.bag"
        with Recording(path, 1) as bag:
            bag.image("/rgb/image", 1, colour(0), "rgb8")
        self.refuses(path, "no topic of depth")
        self.refuses(self.dir / "nowhere.bag", "is missing")
        path = self.dir / "bayer.bag"
        with Recording(path, 1) as bag:
            bag.image("/rgb/image", 1, colour(0)[..., 0], "bayer_rggb8")
            bag.image("/depth/image", 1, depth_mm(0), "16UC1")
            bag.info("/rgb/camera_info", 1, 30.5)
        self.refuses(path, "bayer_rggb8")

    def test_cut_and_foreign_files_are_refused(self):
        whole = self.recordings(write_usual)[0].read_bytes()
        path = self.dir / "cut.bag"
        for share in (0.02, 0.3, 0.9):
            path.write_bytes(whole[:int(share * len(whole))])
            self.refuses(path, "cut.bag")
        path.write_bytes(b"no recording at all")
        self.refuses(path, "cut.bag")

    def test_a_folder_that_exists_is_left_alone(self):
        recording = self.recordings(write_usual)[0]
        self.out.mkdir()
        (self.out / "mine.txt").write_text("mine")
        result = self.run_script(recording)
        self.assertEqual(result.returncode, 3)
        self.assertEqual([p.name for p in self.out.iterdir()], ["mine.txt"])

    def test_azure_kinect(self):
        depth = [numpy.full((288, 320), 900 + i, numpy.uint16) for i in range(FRAMES)]
        jpeg = b"\xff\xd8\xff" + bytes(2000)  # copied as it is
        path = self.dir / "azure.mkv"
        path.write_bytes(azure(jpeg, depth))
        self.imports(path)
        names = [line.split() for line in (self.out / "depth.txt").read_text().splitlines()[1:]]
        self.assertEqual([float(t) for t, _ in names], [0.005, 0.038, 0.071, 0.104])
        numpy.testing.assert_array_equal(read_png((self.out / names[3][1]).read_bytes()), depth[3])
        self.assertEqual((self.out / "rgb/0.005000.jpg").read_bytes(), jpeg)
        settings = (self.out / "capture.yaml").read_text()
        # The calibration's numbers are shares of 1280 x 960 and of 512 x 512, of which 120 rows, and (96, 90), are cut off.
        self.assertIn("camera: {width: 1280, height: 720, fx: 614.4, fy: 460.8, cx: 639.5, cy: 359.5", settings)
        self.assertIn("depth_camera: {width: 320, height: 288, fx: 256, fy: 256, cx: 159.5, cy: 165.5", settings)
        self.assertIn("coefficients: [0.3, -0.2, -0.0002, 0.0001, 0.05, 0.6, -0.1, 0.02]", settings)
        self.assertIn("translation_m: [-0.032, -0.002, 0.004]", settings)

    def test_azure_kinect_cut_short_gives_what_is_whole(self):
        depth = [numpy.full((288, 320), 900 + i, numpy.uint16) for i in range(FRAMES)]
        whole = azure(b"\xff\xd8\xff" + bytes(2000), depth)
        path = self.dir / "azure.mkv"
        path.write_bytes(whole[:-1000])
        self.assertIn("stopped", self.imports(path).stderr)
        self.assertEqual(len((self.out / "depth.txt").read_text().splitlines()), FRAMES)
        shutil.rmtree(self.out)
        path.write_bytes(whole[:600])
        self.refuses(path, "azure.mkv")
        path.write_bytes(azure(b"\xff\xd8\xff", depth, calibration=False))
        self.refuses(path, "calibration.json")

    def test_packages_are_those_that_users_are_told_to_install(self):
        pins = dict(re.findall(r"^(\S+)==(\S+)$", pathlib.Path(SCRIPT).with_name("import_requirements.txt").read_text(), re.M))
        self.assertEqual(set(pins), {"rosbags", "mcap", "numpy", "lzfse"})
        for name in ("rosbags", "mcap", "numpy"):  # lzfse is asked for by import_record3d_test.py
            version = pins[name]
            self.assertEqual(importlib.metadata.version(name), version, name)


if __name__ == "__main__":
    unittest.main()
