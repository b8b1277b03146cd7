#!/usr/bin/env python3
"""Makes a capture that deepslam reads of a recording in one file.

    import_recording.py RECORDING FOLDER [--colour TOPIC] [--depth TOPIC] [--poses TOPIC] [--every N] [--list]

RECORDING is a bag of ROS 1 (RealSense's viewer writes these too), one of ROS 2 (its folder, or the .db3 or .mcap file), an
Azure Kinect recording (.mkv), or a Record3D one (.r3d, or the folder it unpacks to). What bags and Record3D need stands in
scripts/import_requirements.txt; an .mkv needs numpy alone. The capture is of layout tum, of Record3D of layout record3d.

Topics are found by their types; where several fit they are listed, and --colour, --depth and --poses choose. Images are copied
as they are where a capture can hold them (JPEG, PNG); raw ones become PNG. Depth keeps its place: where it is not registered to
colour, its camera and where it sits are written to capture.yaml, and deepslam registers it. Lenses are written there too.
FOLDER must not exist; it appears when it is whole.
"""
import argparse
import bisect
import json
import os
import pathlib
import re
import struct
import sys

from record3d_recording import import_record3d, is_record3d
from recording_files import MAX_SIDE_PX, Progress, Refused, new_folder, numpy, png, raw_of_metres

# Colour and depth of one moment, s: half a frame at 30 Hz, rounded up, as deepslam pairs them.
MAX_DIFFERENCE_S = 0.02
# Raw depth of one metre, for depth that is recorded as real numbers: a fifth of a millimetre, up to 13 m.
REAL_UNITS_PER_M = 5000


# --- images

def of_yuv422(raw, luma_first):
    """RGB of pairs of pixels that share their colour (BT.601, full range as cameras write it)."""
    pairs = raw.reshape(raw.shape[0], -1, 4).astype(numpy.float32)
    y0, u, y1, v = (pairs[..., k] for k in ((0, 1, 2, 3) if luma_first else (1, 0, 3, 2)))
    u, v = u - 128, v - 128
    rgb = numpy.stack([numpy.stack([y + 1.402 * v, y - 0.344136 * u - 0.714136 * v, y + 1.772 * u], -1) for y in (y0, y1)], 2)
    return numpy.clip(numpy.rint(rgb), 0, 255).astype(numpy.uint8).reshape(raw.shape[0], -1, 3)


def rows_of(message, bytes_per_pixel, where):
    """The image's bytes, a row each, without what stands behind a row."""
    width, height, step = int(message.width), int(message.height), int(message.step)
    data = numpy.asarray(message.data, numpy.uint8).reshape(-1)
    if not (1 <= width <= MAX_SIDE_PX and 1 <= height <= MAX_SIDE_PX):
        raise Refused(f"{where}: an image of {width} x {height} px")
    if step < width * bytes_per_pixel or data.size < step * height:
        raise Refused(f"{where}: an image of {width} x {height} px has {data.size} bytes in rows of {step} (truncated?)")
    return data[:step * height].reshape(height, step)[:, :width * bytes_per_pixel]


def colour_file(message, where):
    """(name's end, bytes) of an Image or CompressedImage."""
    if not hasattr(message, "encoding"):
        data = bytes(message.data)
        for end, begin in (("jpg", b"\xff\xd8\xff"), ("png", b"\x89PNG")):
            if data.startswith(begin):
                return end, data
        raise Refused(f"{where}: compressed colour is neither JPEG nor PNG but '{message.format}'")
    encoding = message.encoding.lower()
    channels = {"rgb8": 3, "8uc3": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "8uc4": 4, "mono8": 1, "8uc1": 1}.get(encoding)
    if encoding in ("yuv422", "uyvy", "yuv422_yuy2", "yuyv", "yuy2"):
        return "png", png(of_yuv422(rows_of(message, 2, where), encoding in ("yuv422_yuy2", "yuyv", "yuy2")))
    if channels is None:
        raise Refused(f"{where}: colour is encoded as '{message.encoding}'; read are rgb8, bgr8, rgba8, bgra8, mono8, yuv422")
    pixels = rows_of(message, channels, where).reshape(int(message.height), int(message.width), channels)
    if channels == 1:
        return "png", png(numpy.repeat(pixels, 3, axis=2))
    pixels = pixels[..., :3] if encoding.startswith(("rgb", "8uc3")) else pixels[..., 2::-1]
    return "png", png(numpy.ascontiguousarray(pixels))


def depth_file(message, where):
    """(bytes of a PNG, raw depth of one metre; None: the recording's own units)."""
    if not hasattr(message, "encoding"):
        data = bytes(message.data)
        begin = data.find(b"\x89PNG", 0, 64)  # compressed_depth_image_transport puts twelve bytes before it
        if begin < 0 or "rvl" in message.format.lower():
            raise Refused(f"{where}: compressed depth is no PNG but '{message.format}'; record raw or PNG depth")
        if "32fc1" in message.format.lower():
            raise Refused(f"{where}: depth of real numbers is compressed by its inverse, which loses it; record 16UC1 or raw")
        return data[begin:], None
    encoding = message.encoding.lower()
    order = ">" if message.is_bigendian else "<"
    if encoding in ("16uc1", "mono16"):
        return png(rows_of(message, 2, where).copy().view(order + "u2").astype(numpy.uint16)), None
    if encoding == "32fc1":
        metres = rows_of(message, 4, where).copy().view(order + "f4")
        return png(raw_of_metres(metres, REAL_UNITS_PER_M)), REAL_UNITS_PER_M
    raise Refused(f"{where}: depth is encoded as '{message.encoding}'; read are 16UC1 and 32FC1")


# --- capture.yaml

def camera_text(camera):
    numbers = ", ".join(f"{name}: {camera[name]:.10g}" for name in ("width", "height", "fx", "fy", "cx", "cy"))
    lens = camera.get("lens")
    if lens and any(lens[1]):
        numbers += f", distortion: {{model: {lens[0]}, coefficients: [{', '.join(f'{k:.10g}' for k in lens[1])}]}}"
    return "{" + numbers + "}"


def settings_text(cameras):
    text = f"format: tum\ncamera: {camera_text(cameras['colour'])}\ndepth_units_per_m: {cameras['units_per_m']:.10g}\n"
    if cameras.get("depth"):
        text += f"depth_camera: {camera_text(cameras['depth'])}\n"
        shift, turn = cameras["colour_from_depth"]
        text += (f"colour_from_depth: {{translation_m: [{', '.join(f'{x:.10g}' for x in shift)}], "
                 f"rotation_xyzw: [{', '.join(f'{x:.10g}' for x in turn)}]}}\n")
    return text


def quaternion_of(matrix):
    """x y z w of a rotation."""
    m = numpy.asarray(matrix, float).reshape(3, 3)
    trace = [1 + m[0, 0] - m[1, 1] - m[2, 2], 1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2], 1 + m.trace()]
    k = int(numpy.argmax(trace))
    q = {0: [trace[0], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
         1: [m[1, 0] + m[0, 1], trace[1], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
         2: [m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], trace[2], m[1, 0] - m[0, 1]],
         3: [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], trace[3]]}[k]
    q = numpy.asarray(q)
    return q / numpy.linalg.norm(q)


def matrix_of(turn):
    x, y, z, w = turn
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class Pose:
    """a_from_b."""

    def __init__(self, shift=(0, 0, 0), turn=(0, 0, 0, 1)):
        self.shift = numpy.asarray(shift, float)
        turn = numpy.asarray(turn, float)
        norm = numpy.linalg.norm(turn)
        self.turn = turn / norm if norm > 0 else numpy.array([0, 0, 0, 1.0])

    def inverse(self):
        back = matrix_of(self.turn).T
        return Pose(-back @ self.shift, quaternion_of(back))

    def __matmul__(self, other):
        matrix = matrix_of(self.turn)
        return Pose(self.shift + matrix @ other.shift, quaternion_of(matrix @ matrix_of(other.turn)))


# --- the capture that is written

class Writer:
    """Images as they come, lists at the end."""

    def __init__(self, folder):
        self.folder = folder
        self.lists = {"rgb": [], "depth": []}
        for name in self.lists:
            (folder / name).mkdir()

    def add(self, stream, time_s, end, data):
        name = f"{stream}/{time_s:.6f}.{end}"
        (self.folder / name).write_bytes(data)
        self.lists[stream].append((time_s, name))

    def finish(self, cameras, poses):
        for stream, lines in self.lists.items():
            lines.sort()
            (self.folder / f"{stream}.txt").write_text("# time file\n" + "".join(f"{t:.6f} {name}\n" for t, name in lines))
        (self.folder / "capture.yaml").write_text(settings_text(cameras))
        if poses:
            lines = (f"{t:.6f} " + " ".join(f"{x:.9g}" for x in (*pose.shift, *pose.turn)) for t, pose in sorted(poses, key=lambda e: e[0]))
            (self.folder / "groundtruth.txt").write_text("# time tx ty tz qx qy qz qw\n" + "\n".join(lines) + "\n")


def write_capture(target, fill):
    """Calls fill(Writer), which returns cameras and poses; the folder appears when all is there."""
    with new_folder(target) as work:
        writer = Writer(work)
        writer.finish(*fill(writer))
        for stream, lines in writer.lists.items():
            if not lines:
                raise Refused(f"the recording holds no {'colour' if stream == 'rgb' else stream} images")
    return {stream: len(lines) for stream, lines in writer.lists.items()}


# --- bags

IMAGE_TYPES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
POSE_TYPES = ("geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped", "nav_msgs/msg/Odometry",
              "geometry_msgs/msg/TransformStamped")
LENSES = {"plumb_bob": "radial-tangential", "rational_polynomial": "rational", "equidistant": "fisheye", "brown_conrady": "radial-tangential",
          "distortion.brown conrady": "radial-tangential", "distortion.inverse brown conrady": "", "none": "", "": ""}
LENS_SIZE = {"radial-tangential": 5, "rational": 8, "fisheye": 4}


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def time_of(message, recorded_ns):
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    time_s = seconds(stamp) if stamp is not None else 0
    return time_s if time_s > 0 else recorded_ns * 1e-9


def common_length(a, b):
    return len(os.path.commonprefix([a, b]))


def is_depth_name(topic):
    return bool(re.search(r"depth|/disparity", topic, re.I))


class Bag:
    def __init__(self, path):
        try:
            from rosbags.highlevel import AnyReader
            from rosbags.typesys import Stores, get_typestore
        except ImportError as fault:
            raise Refused(f"the Python package {fault.name} is missing; pip install -r scripts/import_requirements.txt") from fault
        self.path = path
        try:
            self.reader = AnyReader([self.root(path)], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
            self.reader.open()
        except Exception as fault:  # the library's own kinds are many
            raise Refused(f"{path}: cannot be read ({fault}); is the recording whole? (ROS 1: rosbag reindex; "
                          "ROS 2: ros2 bag reindex)") from fault

    @staticmethod
    def root(path):
        """Of ROS 2, the folder with metadata.yaml."""
        if path.is_file() and path.suffix.lower() in (".db3", ".mcap") and (path.parent / "metadata.yaml").is_file():
            return path.parent
        return path

    def topics(self, types):
        return {c.topic: c for c in self.reader.connections if c.msgtype in types and c.msgcount > 0}

    def messages(self, topics, every=None):
        connections = [c for c in self.reader.connections if c.topic in topics]
        total = sum(c.msgcount for c in connections)
        progress, count = Progress("reading"), 0
        try:
            for connection, recorded_ns, raw in self.reader.messages(connections=connections):
                count += 1
                progress(count, total)
                yield connection.topic, recorded_ns, self.reader.deserialize(raw, connection.msgtype)
        except Refused:
            raise
        except Exception as fault:
            raise Refused(f"{self.path}: ends or is damaged at message {count} of {total} ({fault})") from fault

    def first(self, topic):
        for _, _, message in self.messages([topic]):
            return message
        return None


def choose(kind, chosen, fitting, option, path):
    """The topic that is named, or the only one that fits."""
    if chosen:
        if chosen in fitting:
            return chosen
        raise Refused(f"{path}: has no {kind} topic '{chosen}'; there are: {', '.join(sorted(fitting)) or 'none'}")
    if len(fitting) == 1:
        return next(iter(fitting))
    if not fitting:
        raise Refused(f"{path}: has no topic of {kind} images (sensor_msgs/Image or CompressedImage)")
    raise Refused(f"{path}: several topics may be {kind}; name one by {option}:\n  " + "\n  ".join(sorted(fitting)))


def preferred(topics):
    """Raw images before compressed ones of the same camera; depth registered to colour before depth as it was taken."""
    kept = dict(topics)
    for topic in topics:
        for end in ("/compressed", "/compressedDepth"):
            if topic.endswith(end) and topic[:-len(end)] in topics:
                kept.pop(topic, None)
    registered = {t: c for t, c in kept.items() if re.search(r"aligned_depth_to_color|depth_registered|depth_to_rgb", t)}
    return registered or kept


def find_images(bag, options):
    images = {t: c for t, c in bag.topics(IMAGE_TYPES).items()
              if not re.search(r"infra|/ir/|/ir_|confidence|fisheye|/theora|compressedDepth$", t, re.I) or t.endswith("compressedDepth")}
    depth = preferred({t: c for t, c in images.items() if is_depth_name(t)})
    colour = preferred({t: c for t, c in images.items() if not is_depth_name(t)})
    every = {**bag.topics(IMAGE_TYPES)}
    return (choose("colour", options.colour, every if options.colour else colour, "--colour", bag.path),
            choose("depth", options.depth, every if options.depth else depth, "--depth", bag.path))


def camera_of(bag, topic):
    """The camera info whose topic's name has most in common with the images'."""
    infos = bag.topics(("sensor_msgs/msg/CameraInfo",))
    if not infos:
        raise Refused(f"{bag.path}: holds no sensor_msgs/CameraInfo, so the camera is unknown; record it, or write capture.yaml yourself")
    name = max(sorted(infos), key=lambda info: common_length(info, topic))
    message = bag.first(name)
    k = numpy.asarray(getattr(message, "k", getattr(message, "K", None)), float)
    d = [float(x) for x in getattr(message, "d", getattr(message, "D", []))]
    if k is None or k.size != 9 or not k[0] > 0:
        raise Refused(f"{bag.path}: {name} holds no camera matrix")
    camera = {"width": int(message.width), "height": int(message.height), "fx": k[0], "fy": k[4], "cx": k[2], "cy": k[5]}
    model = message.distortion_model.lower()
    if any(d):
        if model not in LENSES:
            raise Refused(f"{bag.path}: {name} has distortion of model '{message.distortion_model}'; known are {', '.join(filter(None, LENSES))}")
        lens = LENSES[model]
        if lens:
            camera["lens"] = (lens, (d + [0.0] * 8)[:LENS_SIZE[lens]])
        else:
            print(f"{name}: lens '{message.distortion_model}' is left out: it is for going the other way, its numbers are small", file=sys.stderr)
    if re.search(r"rect", topic):
        camera.pop("lens", None)
    return camera, message.header.frame_id


class Frames:
    """Where frames sit on one another, by /tf_static, /tf and RealSense's tf topics."""

    def __init__(self, bag):
        self.parent = {}
        topics = [c.topic for c in bag.reader.connections if c.msgtype == "tf2_msgs/msg/TFMessage" and c.topic.endswith("tf_static")]
        for _, _, message in bag.messages(topics) if topics else ():
            for transform in message.transforms:
                self.add(transform)

    def add(self, stamped):
        t, q = stamped.transform.translation, stamped.transform.rotation
        self.parent[stamped.child_frame_id.lstrip("/")] = (stamped.header.frame_id.lstrip("/"),
                                                           Pose((t.x, t.y, t.z), (q.x, q.y, q.z, q.w)))

    def chain(self, name):
        """(frame, frame_from_name) from the name up to its root."""
        pose, steps, seen = Pose(), [], set()
        name = name.lstrip("/")
        while name not in seen:
            seen.add(name)
            steps.append((name, pose))
            if name not in self.parent:
                break
            name, own = self.parent[name]
            pose = own @ pose
        return steps

    def between(self, a, b):
        """a_from_b; None where they are not joined."""
        of_a = dict(self.chain(a))
        for name, common_from_b in self.chain(b):
            if name in of_a:
                return of_a[name].inverse() @ common_from_b
        return None


def realsense_place(bag, colour_topic, depth_topic):
    """RealSense's viewer writes where each stream sits against the first as geometry_msgs/Transform."""
    def own(topic):
        name = next((c.topic for c in bag.reader.connections if c.msgtype == "geometry_msgs/msg/Transform"
                     and c.topic.startswith(topic.rsplit("/image", 1)[0] + "/tf")), None)
        message = bag.first(name) if name else None
        if message is None:
            return None
        t, q = message.translation, message.rotation
        return Pose((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))
    colour, depth = own(colour_topic), own(depth_topic)
    if colour is None or depth is None:
        return None
    return colour.inverse() @ depth


def depth_units(bag, depth_topic):
    """RealSense's option Depth Units (m of one unit); ROS says millimetres."""
    stem = depth_topic.split("/Depth_", 1)[0]
    for c in bag.reader.connections:
        if c.topic.startswith(stem) and re.search(r"/option/Depth[ _]Units/value$", c.topic):
            metres = float(bag.first(c.topic).data)
            if 1e-6 < metres < 1:
                # A number of 32 bits stands for a whole one of raw depth.
                return round(1 / metres) if abs(metres * round(1 / metres) - 1) < 1e-6 else 1 / metres
    return 1000.0


def bag_cameras(bag, colour_topic, depth_topic):
    colour, colour_frame = camera_of(bag, colour_topic)
    depth, depth_frame = camera_of(bag, depth_topic)
    cameras = {"colour": colour}
    if re.search(r"aligned_depth_to_color|depth_registered|depth_to_rgb", depth_topic):
        return cameras
    # RealSense's viewer gives all streams one frame.
    place = realsense_place(bag, colour_topic, depth_topic)
    if place is None and depth_frame != colour_frame:
        place = Frames(bag).between(colour_frame, depth_frame)
    if place is None and depth == colour:
        return cameras
    if place is None:
        raise Refused(f"{bag.path}: depth ({depth_frame}) is not registered to colour ({colour_frame}), and no tf_static says where it sits; "
                      "record aligned depth or tf_static")
    cameras["depth"] = depth
    cameras["colour_from_depth"] = (place.shift, place.turn)
    return cameras


def pose_of(message):
    if hasattr(message, "transform"):
        t, q = message.transform.translation, message.transform.rotation
    else:
        pose = message.pose.pose if hasattr(message.pose, "pose") else message.pose
        t, q = pose.position, pose.orientation
    return Pose((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def list_topics(bag):
    for c in sorted(bag.reader.connections, key=lambda c: c.topic):
        print(f"{c.topic}  {c.msgtype}  {c.msgcount}")


def import_bag(path, options):
    bag = Bag(path)
    if options.list:
        return list_topics(bag)
    colour_topic, depth_topic = find_images(bag, options)
    if options.poses and options.poses not in bag.topics(POSE_TYPES):
        raise Refused(f"{path}: has no topic of poses '{options.poses}'; there are: {', '.join(sorted(bag.topics(POSE_TYPES))) or 'none'}")
    cameras = bag_cameras(bag, colour_topic, depth_topic)
    print(f"colour {colour_topic}, depth {depth_topic}" + (f", poses {options.poses}" if options.poses else ""), file=sys.stderr)

    def fill(writer):
        units, poses, counts = None, [], {colour_topic: 0, depth_topic: 0}
        for topic, recorded_ns, message in bag.messages([colour_topic, depth_topic] + ([options.poses] if options.poses else [])):
            time_s = time_of(message, recorded_ns)
            where = f"{path}: {topic} at {time_s:.6f} s"
            if topic == options.poses:
                poses.append((time_s, pose_of(message)))
                continue
            counts[topic] += 1
            if (counts[topic] - 1) % options.every:
                continue
            if topic == colour_topic:
                writer.add("rgb", time_s, *colour_file(message, where))
            else:
                data, units = depth_file(message, where)
                writer.add("depth", time_s, "png", data)
        cameras["units_per_m"] = units or depth_units(bag, depth_topic)
        return cameras, poses

    return write_capture(options.folder, fill)


# --- Azure Kinect

# Elements of Matroska that are gone into, and those that are read.
SEGMENT, TRACKS, TRACK, CLUSTER, GROUP, ATTACHMENTS, ATTACHED, INFO, TAGS, TAG, SIMPLE = (
    0x18538067, 0x1654AE6B, 0xAE, 0x1F43B675, 0xA0, 0x1941A469, 0x61A7, 0x1549A966, 0x1254C367, 0x7373, 0x67C8)
GONE_INTO = {SEGMENT, TRACKS, CLUSTER, GROUP, ATTACHMENTS, INFO, TAGS, TAG}
TRACK_NUMBER, TRACK_NAME, CODEC_PRIVATE, FILE_NAME, FILE_DATA, CLUSTER_TIME, BLOCK, SIMPLE_BLOCK, TIME_SCALE, TAG_NAME, TAG_TEXT = (
    0xD7, 0x536E, 0x63A2, 0x466E, 0x465C, 0xE7, 0xA1, 0xA3, 0x2AD7B1, 0x45A3, 0x4487)
# Azure Kinect's modes: size of the image that the calibration is of, what is cut off it left and above, and what is left.
DEPTH_MODES = {(320, 288): ((512, 512), (96, 90)), (640, 576): ((1024, 1024), (192, 180)), (512, 512): ((512, 512), (0, 0)),
               (1024, 1024): ((1024, 1024), (0, 0))}
COLOUR_MODES = {(1280, 720): ((1280, 960), (0, 120)), (1920, 1080): ((1920, 1440), (0, 180)), (2560, 1440): ((2560, 1920), (0, 240)),
                (2048, 1536): ((2048, 1536), (0, 0)), (3840, 2160): ((3840, 2880), (0, 360)), (4096, 3072): ((4096, 3072), (0, 0))}


class Matroska:
    """The elements of a file, one after the other; nothing but one block is held."""

    def __init__(self, path):
        self.path = path
        self.size = path.stat().st_size
        self.file = open(path, "rb")

    def number(self, keep_length_bit):
        first = self.file.read(1)
        if not first or first[0] == 0:
            raise Refused(f"{self.path}: is damaged or cut at byte {self.file.tell()}")
        length = 8 - first[0].bit_length() + 1
        rest = self.file.read(length - 1)
        if len(rest) < length - 1:
            raise Refused(f"{self.path}: ends at byte {self.file.tell()} within an element (was the recorder stopped?)")
        value = first[0] if keep_length_bit else first[0] & (0xFF >> length)
        for byte in rest:
            value = value << 8 | byte
        return value, value == (1 << 7 * length) - 1

    def elements(self, ends=None):
        """(id, payload or None for those that are gone into); containers' contents follow them."""
        while self.file.tell() < self.size:
            try:
                kind, _ = self.number(True)
                length, unknown = self.number(False)
            except Refused as fault:
                # A recorder that was killed leaves a last element that is not whole.
                print(f"{fault}; what lies before is taken", file=sys.stderr)
                return
            if kind in GONE_INTO:
                yield kind, None
                continue
            begin = self.file.tell()
            if unknown or begin + length > self.size:
                print(f"{self.path}: ends within an element (was the recorder stopped?); what lies before is taken", file=sys.stderr)
                return
            if kind in (TRACK, ATTACHED, SIMPLE):
                yield kind, self.members(begin + length)
            elif kind in (CLUSTER_TIME, BLOCK, SIMPLE_BLOCK, TIME_SCALE):
                yield kind, self.file.read(length)
            self.file.seek(begin + length)

    def members(self, end):
        found = {}
        while self.file.tell() < end:
            kind, _ = self.number(True)
            length, _ = self.number(False)
            if self.file.tell() + length > end:
                raise Refused(f"{self.path}: is damaged at byte {self.file.tell()}")
            found[kind] = self.file.read(length)
        return found


def calibrated(entry, size, modes, path):
    """The camera of a mode by the calibration's numbers, which are shares of its own image's sides."""
    if size not in modes:
        raise Refused(f"{path}: images of {size[0]} x {size[1]} px are of no mode that is known")
    (width, height), (left, above) = modes[size]
    try:
        p = [float(x) for x in entry["Intrinsics"]["ModelParameters"]]
        cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, _, _, p2, p1 = p[:14]
    except (KeyError, TypeError, ValueError) as fault:
        raise Refused(f"{path}: calibration has no 14 ModelParameters") from fault
    return {"width": size[0], "height": size[1], "fx": fx * width, "fy": fy * height, "cx": cx * width - left - 0.5,
            "cy": cy * height - above - 0.5, "lens": ("rational", [k1, k2, p1, p2, k3, k4, k5, k6])}


def azure_cameras(calibration, colour_size, depth_size, path):
    try:
        listed = json.loads(calibration.rstrip(b"\0"))["CalibrationInformation"]["Cameras"]
        entries = {entry["Location"]: entry for entry in listed}
        depth_entry, colour_entry = entries["CALIBRATION_CameraLocationD0"], entries["CALIBRATION_CameraLocationPV0"]
        turn = numpy.asarray(colour_entry["Rt"]["Rotation"], float).reshape(3, 3)
        shift = numpy.asarray(colour_entry["Rt"]["Translation"], float).reshape(3)
    except (ValueError, KeyError, TypeError) as fault:
        raise Refused(f"{path}: its calibration cannot be read ({fault})") from fault
    return {"colour": calibrated(colour_entry, colour_size, COLOUR_MODES, path),
            "depth": calibrated(depth_entry, depth_size, DEPTH_MODES, path),
            "colour_from_depth": (shift, quaternion_of(turn)), "units_per_m": 1000.0}


def bitmap_size(private, path, name):
    """Width, height and code of a track, out of its BITMAPINFOHEADER."""
    if len(private) < 40:
        raise Refused(f"{path}: track {name} has no size")
    width, height = struct.unpack_from("<ii", private, 4)
    return (width, abs(height)), private[16:20]


def import_azure(path, options):
    source = Matroska(path)
    tracks, calibration, scale_ns = {}, None, 1_000_000
    for kind, payload in source.elements():
        if kind == TRACK:
            name = payload.get(TRACK_NAME, b"").decode("ascii", "replace").rstrip("\0")
            if CODEC_PRIVATE in payload and name in ("COLOR", "DEPTH"):
                tracks[payload[TRACK_NUMBER][-1]] = (name, *bitmap_size(payload[CODEC_PRIVATE], path, name))
        elif kind == ATTACHED and payload.get(FILE_NAME, b"").rstrip(b"\0") == b"calibration.json":
            calibration = payload.get(FILE_DATA, b"")
        elif kind == TIME_SCALE:
            scale_ns = int.from_bytes(payload, "big")
        elif kind == CLUSTER and calibration:
            break
    by_name = {name: (size, code) for name, size, code in tracks.values()}
    if options.list:
        for name, (size, code) in by_name.items():
            print(f"{name}  {size[0]} x {size[1]}  {code.decode('ascii', 'replace')}")
        return None
    for name in ("COLOR", "DEPTH"):
        if name not in by_name:
            raise Refused(f"{path}: has no track {name}; is it an Azure Kinect recording with colour and depth?")
    if calibration is None:
        raise Refused(f"{path}: has no attachment calibration.json, so the cameras are unknown")
    if by_name["COLOR"][1] not in (b"MJPG", b"YUY2"):
        raise Refused(f"{path}: colour is {by_name['COLOR'][1].decode('ascii', 'replace')}; read are MJPG and YUY2")
    if by_name["DEPTH"][1] != b"b16g":
        raise Refused(f"{path}: depth is {by_name['DEPTH'][1].decode('ascii', 'replace')}, not 16 bits of grey")
    cameras = azure_cameras(calibration, by_name["COLOR"][0], by_name["DEPTH"][0], path)

    def fill(writer):
        cluster_time, progress, counts = 0, Progress("reading"), {"COLOR": 0, "DEPTH": 0}
        source.file.seek(0)
        for kind, payload in source.elements():
            progress(source.file.tell(), source.size)
            if kind == CLUSTER_TIME:
                cluster_time = int.from_bytes(payload, "big")
            if kind not in (BLOCK, SIMPLE_BLOCK) or len(payload) < 4 or not payload[0] & 0x80:
                continue
            name, size, code = tracks.get(payload[0] & 0x7F, (None, None, None))
            if name is None:
                continue
            counts[name] += 1
            if (counts[name] - 1) % options.every:
                continue
            time_s = (cluster_time + struct.unpack(">h", payload[1:3])[0]) * scale_ns * 1e-9
            data = payload[4:]
            if name == "DEPTH":
                if len(data) != 2 * size[0] * size[1]:
                    raise Refused(f"{path}: depth at {time_s:.6f} s has {len(data)} bytes, {size[0]} x {size[1]} px need {2 * size[0] * size[1]}")
                writer.add("depth", time_s, "png", png(numpy.frombuffer(data, ">u2").reshape(size[1], size[0]).astype(numpy.uint16)))
            elif code == b"MJPG":
                writer.add("rgb", time_s, "jpg", data)
            else:
                if len(data) != 2 * size[0] * size[1]:
                    raise Refused(f"{path}: colour at {time_s:.6f} s has {len(data)} bytes, {size[0]} x {size[1]} px need {2 * size[0] * size[1]}")
                writer.add("rgb", time_s, "png", png(of_yuv422(numpy.frombuffer(data, numpy.uint8).reshape(size[1], -1), True)))
        return cameras, []

    return write_capture(options.folder, fill)


# --- the program

def is_matroska(path):
    with open(path, "rb") as file:
        return file.read(4) == b"\x1a\x45\xdf\xa3"


def paired(folder):
    times = []
    for stream in ("rgb", "depth"):
        lines = (folder / f"{stream}.txt").read_text().splitlines()[1:]
        times.append([float(line.split()[0]) for line in lines])
    near = 0
    for t in times[1]:
        k = bisect.bisect_left(times[0], t)
        near += any(abs(times[0][n] - t) <= MAX_DIFFERENCE_S for n in (k - 1, k) if 0 <= n < len(times[0]))
    return near


def import_one(options):
    recording = options.recording
    file = recording.is_file()
    azure, record3d = file and is_matroska(recording), is_record3d(recording)
    topics = options.colour or options.depth or options.poses
    if topics and (azure or record3d):
        raise Refused(f"{recording}: has no topic '{topics}': --colour, --depth and --poses are for bags; all that it holds is taken")
    if record3d:
        import_record3d(recording, options)
        return
    counts = (import_azure if azure else import_bag)(recording, options)
    if not counts:
        return
    near = paired(options.folder)
    print(f"{options.folder}: {counts['rgb']} colour and {counts['depth']} depth images, {near} pairs", file=sys.stderr)
    if 2 * near < counts["depth"]:
        print(f"warning: {counts['depth'] - near} depth images have no colour within {MAX_DIFFERENCE_S} s", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0], formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path, nargs="?")
    parser.add_argument("--colour", help="topic of the colour images")
    parser.add_argument("--depth", help="topic of the depth images")
    parser.add_argument("--poses", help="topic of the camera's poses (PoseStamped, Odometry); they become groundtruth.txt")
    parser.add_argument("--every", type=int, default=1, help="take every n-th image of each stream")
    parser.add_argument("--list", action="store_true", help="list what the recording holds, and write nothing")
    options = parser.parse_args()
    if options.folder is None and not options.list:
        parser.error("name the FOLDER to write (or --list)")
    if options.every < 1:
        parser.error("--every has to be 1 or more")
    try:
        if numpy is None:
            raise Refused("the Python package numpy is missing; pip install -r scripts/import_requirements.txt")
        if not options.recording.exists():
            raise Refused(f"{options.recording}: is missing")
        import_one(options)
    except (Refused, OSError) as fault:
        print(f"import_recording.py: {fault}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
