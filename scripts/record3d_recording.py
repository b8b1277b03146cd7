"""Record3D's recordings: .r3d files, which are zip archives, and the folders that come out of them.

They hold `metadata` (JSON) and for each frame rgbd/N.jpg, rgbd/N.depth (32-bit real numbers, m, row by row) and rgbd/N.conf
(8 bits: 0 low, 1 medium, 2 high), the latter two packed by LZFSE. What comes out is deepslam's layout record3d: rgb/N.jpg as it
was, depth/N.png, confidence/N.png, and metadata.json with all that the app states.
"""
import json
import math
import pathlib
import re
import struct
import sys
import zipfile
import zlib

from recording_files import MAX_SIDE_PX, Progress, Refused, new_folder, numpy, png, raw_of_metres, warn

# Raw depth of one metre, as deepslam holds real numbers: a third of a millimetre, up to 21 m.
UNITS_PER_M = 3000
# Sides of depth images in px: a phone's have 256, its face sensor's 960.
MAX_DEPTH_PX = 4096
# What one file may hold. A day of 60 frames/s is 5 million frames, whose poses and cameras take 1 GB; images are far smaller.
MAX_METADATA_BYTES, MAX_IMAGE_BYTES = 1 << 30, 1 << 28
# Shapes of colour and depth differ by less, as whole pixels of small images are rounded.
SAME_SHAPE = 0.02
# Warnings of single frames that are printed; their number is told.
MAX_TOLD = 5
# A picture's end stands within this much of the file's: some writers add a few bytes.
END_BYTES = 4096

FRAME_FILE = re.compile(r"rgbd/(\d{1,9})\.(jpg|jpeg|png|depth|conf)", re.I)


class Damaged(Exception):
    """One file of a frame that cannot be used, and why."""


# --- where the files lie

def entry_of_metadata(names):
    """The first of them all, the nearest to the top."""
    fitting = [n for n in names if pathlib.PurePosixPath(n).name in ("metadata", "metadata.json") and "__MACOSX" not in n]
    return min(fitting, key=lambda n: (n.count("/"), n), default=None)


class Archive:
    """Members of the .r3d by their names, which are looked up and never become paths."""

    def __init__(self, path):
        try:
            self.zip = zipfile.ZipFile(path)
        except (zipfile.BadZipFile, NotImplementedError, ValueError) as fault:
            raise Refused(f"{path}: is cut or damaged ({fault}): copy it again from the phone, or see what 'zip -FF' saves") from fault
        infos = {info.filename.replace("\\", "/"): info for info in self.zip.infolist()}
        self.metadata = entry_of_metadata(infos)
        top = "" if self.metadata is None else self.metadata[:-len(pathlib.PurePosixPath(self.metadata).name)]
        self.members = {name[len(top):]: info for name, info in infos.items() if name.startswith(top)}
        self.metadata = self.metadata and self.metadata[len(top):]

    def names(self):
        return list(self.members)

    def read(self, name, most_bytes):
        info = self.members[name]
        if info.file_size > most_bytes:
            raise Damaged(f"is said to hold {info.file_size} bytes, {most_bytes} at most can be")
        try:
            return self.zip.read(info)
        except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, NotImplementedError, RuntimeError) as fault:
            raise Damaged(f"cannot be unpacked ({fault})") from fault


class Folder:
    def __init__(self, path):
        self.path = path
        found = [path / name for name in ("metadata", "metadata.json") if (path / name).is_file()]
        self.metadata = found[0].name if found else None

    def names(self):
        return [f"rgbd/{file.name}" for file in (self.path / "rgbd").iterdir()]

    def read(self, name, most_bytes):
        try:
            with open(self.path / name, "rb") as file:
                data = file.read(most_bytes + 1)
        except OSError as fault:
            raise Damaged(f"cannot be read ({fault.strerror})") from fault
        if len(data) > most_bytes:
            raise Damaged(f"holds more than the {most_bytes} bytes that can be")
        return data


def is_record3d(path):
    if path.is_dir():
        return (path / "rgbd").is_dir()
    with open(path, "rb") as file:
        # The second is an archive of nothing.
        return file.read(4) in (b"PK\x03\x04", b"PK\x05\x06") or path.suffix.lower() == ".r3d"


# --- metadata

def brief(value):
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def are_numbers(value, count):
    return isinstance(value, list) and len(value) == count and all(map(is_number, value))


def parse_real(text):
    value = float(text)
    return value if math.isfinite(value) else None


class Metadata:
    """The checked fields; `written` is all of them, for metadata.json."""

    def __init__(self, data, where):
        self.where = where
        try:
            # Neither "NaN" nor what overflows is JSON for other readers.
            self.written = json.loads(data, parse_constant=lambda _: None, parse_float=parse_real)
        except (ValueError, RecursionError) as fault:
            raise Refused(f"{where}: is not JSON ({fault}): damaged? Copy the recording again") from fault
        if not isinstance(self.written, dict):
            raise Refused(f"{where}: is {brief(self.written)}, not a JSON object: is it Record3D's?")
        self.size = (self.side("w", MAX_SIDE_PX), self.side("h", MAX_SIDE_PX))
        self.depth_size = None
        if any(self.written.get(name) is not None for name in ("dw", "dh")):
            self.depth_size = (self.side("dw", MAX_DEPTH_PX), self.side("dh", MAX_DEPTH_PX))
            self.check_shape(self.depth_size)
        k = self.written.get("K")
        rows = isinstance(k, list) and len(k) == 3 and all(are_numbers(row, 3) for row in k)
        if not rows and not are_numbers(k, 9):
            raise Refused(f"{where}: field 'K' is {brief(k)}, not the 9 numbers of the camera's matrix, column by column; correct it")
        self.poses = self.per_frame("poses", 7, "qx qy qz qw tx ty tz")
        self.cameras = self.per_frame("perFrameIntrinsicCoeffs", 4, "fx fy cx cy")
        self.times = self.listed("frameTimestamps", "a time in seconds")
        fps = self.written.get("fps")
        if fps is not None and not (is_number(fps) and fps > 0):
            raise Refused(f"{where}: field 'fps' is {brief(fps)}, not frames per second; correct or remove it")

    def side(self, name, most):
        value = self.written.get(name)
        if not is_number(value) or not 1 <= value <= most or value != int(value):
            raise Refused(f"{self.where}: field '{name}' is {brief(value)}, not a side of 1 to {most} px; correct it")
        return int(value)

    def same_shape(self, size):
        return abs(size[0] * self.size[1] / (size[1] * self.size[0]) - 1) <= SAME_SHAPE

    def check_shape(self, size):
        if not self.same_shape(size):
            raise Refused(f"{self.where}: depth of {size[0]} x {size[1]} px (fields 'dw', 'dh') has another shape than colour of "
                          f"{self.size[0]} x {self.size[1]} ('w', 'h'): is one of them the wrong way round? Correct it")

    def listed(self, name, entry):
        value = self.written.get(name)
        if value is None:
            return []
        if not isinstance(value, list):
            raise Refused(f"{self.where}: field '{name}' is {brief(value)}, not a list with {entry} for each frame; correct or remove it")
        return value

    def per_frame(self, name, count, meaning):
        """The list; entries that are no such numbers become none."""
        entries = self.listed(name, f"{count} numbers ({meaning})")
        for n, entry in enumerate(entries):
            if not are_numbers(entry, count):
                entries[n] = None
        return entries

    def infer_depth_size(self, num_px):
        """Old recordings do not state it: depth has colour's shape."""
        width = round(math.sqrt(num_px * self.size[0] / self.size[1]))
        if width < 1 or num_px % width or not self.same_shape((width, num_px // width)):
            raise Damaged(f"has {num_px} px, which is no image of the shape of colour, {self.size[0]} x {self.size[1]}; fields 'dw' and 'dh' "
                          "are missing, state them in metadata")
        self.depth_size = (width, num_px // width)


# --- LZFSE

def unpacker():
    """decompress() of either package there is; one of them needs a compiler to be installed."""
    for name in ("lzfse", "liblzfse"):
        try:
            return __import__(name)
        except ImportError:
            continue
    raise Refused("the Python package lzfse is missing, by which Record3D's depth is packed; "
                  "pip install -r scripts/import_requirements.txt")


def stated_size(data):
    """Bytes that a stream unpacks to, by the heads of its blocks. The library itself believes what is stated of the first."""
    at = total = 0
    while data[at:at + 4] != b"bvx$":
        head = data[at:at + 32]
        kind = head[:4]
        # 8 bytes: what every block begins with; blocks of the second version have 24 more.
        if len(head) < (32 if kind == b"bvx2" else 12):
            raise Damaged(f"is cut at byte {len(data)}, within an LZFSE block")
        raw, packed = struct.unpack_from("<II", head, 4)
        if kind == b"bvx-":
            length = 8 + raw
        elif kind == b"bvxn":
            length = 12 + packed
        elif kind == b"bvx2":
            fields = struct.unpack_from("<QQQ", head, 8)
            length = (fields[2] & 0xFFFFFFFF) + (fields[0] >> 20 & 0xFFFFF) + (fields[1] >> 40 & 0xFFFFF)
            if (fields[0] >> 40 & 0xFFFFF) > raw:
                raise Damaged(f"has more matches than bytes in the LZFSE block at byte {at}")
        else:
            raise Damaged(f"has no LZFSE block at byte {at}")
        if length < 8 or at + length + 4 > len(data):
            raise Damaged(f"is cut at byte {len(data)}, within an LZFSE block")
        at, total = at + length, total + raw
    return total


def unpacked(data, most_bytes):
    """As it is where it was stored unpacked; the caller tells by its size."""
    if data[:3] != b"bvx":
        return data
    size = stated_size(data)
    if size > most_bytes:
        raise Damaged(f"unpacks to {size} bytes, more than an image can have")
    library = unpacker()
    try:
        plain = library.decompress(data)
    except (library.error, MemoryError) as fault:
        raise Damaged("is damaged: LZFSE cannot unpack it") from fault
    if len(plain) != size:
        raise Damaged(f"unpacks to {len(plain)} bytes where {size} are stated")
    return plain


# --- frames

class Reader:
    def __init__(self, path):
        self.path = path
        self.files = Folder(path) if path.is_dir() else Archive(path)
        self.frames = {}  # number -> kind -> name
        for name in sorted(self.files.names()):
            match = FRAME_FILE.fullmatch(name)
            if match:
                kind = match[2].lower()
                self.frames.setdefault(int(match[1]), {}).setdefault(kind if kind in ("depth", "conf") else "colour", name)
        if self.files.metadata is None or not self.frames:
            missing = "'metadata'" if self.files.metadata is None else "'rgbd/0.jpg' and 'rgbd/0.depth'"
            raise Refused(f"{path}: has no {missing}, so it is no recording of Record3D or not whole; another archive is to be unpacked, "
                          "and its folder named to deepslam")
        where = f"{path}: {self.files.metadata}"
        try:
            data = self.files.read(self.files.metadata, MAX_METADATA_BYTES)
        except Damaged as fault:
            raise Refused(f"{where}: {fault}; copy the recording again") from fault
        self.metadata = Metadata(data, where)

    def read(self, number, kind, most_bytes):
        name = self.frames[number].get(kind)
        if name is None:
            raise Damaged(f"rgbd/{number}: has no {kind}")
        try:
            data = self.files.read(name, most_bytes)
            return data if kind == "colour" else unpacked(data, most_bytes)
        except Damaged as fault:
            raise Damaged(f"{name}: {fault}") from fault

    def colour(self, number):
        """(name's end, the file)."""
        data, name = self.read(number, "colour", MAX_IMAGE_BYTES), self.frames[number]["colour"]
        if data.startswith(b"\x89PNG") and b"IEND" in data[-END_BYTES:]:
            return "png", data
        if not data.startswith(b"\xff\xd8\xff") or b"\xff\xd9" not in data[-END_BYTES:]:
            raise Damaged(f"{name}: is no whole JPEG ({len(data)} bytes)")
        return "jpg", data

    def depth(self, number):
        """m, 0 where there is none."""
        data, name = self.read(number, "depth", 4 * MAX_DEPTH_PX ** 2), self.frames[number]["depth"]
        if self.metadata.depth_size is None and data and len(data) % 4 == 0:
            try:
                self.metadata.infer_depth_size(len(data) // 4)
            except Damaged as fault:
                raise Damaged(f"{name}: {fault}") from fault
        width, height = self.metadata.depth_size or (0, 0)
        if len(data) != 4 * width * height or not data:
            raise Damaged(f"{name}: unpacks to {len(data)} bytes, depth of {width} x {height} px (fields 'dw', 'dh' of "
                          f"{self.files.metadata}) has {4 * width * height}")
        return numpy.frombuffer(data, "<f4").reshape(height, width)

    def confidence(self, number):
        """None where there is none that fits depth."""
        width, height = self.metadata.depth_size
        try:
            data = self.read(number, "conf", MAX_DEPTH_PX ** 2)
        except Damaged:
            return None
        return numpy.frombuffer(data, numpy.uint8).reshape(height, width) if len(data) == width * height else None


def tell(path, faults, total):
    for fault in faults[:MAX_TOLD]:
        warn(f"{path}: {fault}; the frame is left out")
    if len(faults) > MAX_TOLD:
        warn(f"{path}: {len(faults)} of {total} frames are left out")


def say_what_is_missing(reader, numbers, without_confidence):
    path, metadata = reader.path, reader.metadata
    for name, entries, instead in (("poses", metadata.poses, "are placed by tracking alone"),
                                   ("perFrameIntrinsicCoeffs", metadata.cameras, "have the camera of 'K'")):
        missing = sum(n >= len(entries) or entries[n] is None for n in numbers)
        if missing and (entries or name == "poses"):
            warn(f"{metadata.where}: field '{name}' has nothing readable for {missing} of {len(numbers)} frames, which {instead}")
    if without_confidence:
        warn(f"{path}: {without_confidence} of {len(numbers)} frames have no rgbd/N.conf that fits and is not 0 alone; all their depth is kept")
    stated = max(len(metadata.poses), len(metadata.times))
    if stated > max(reader.frames) + 1:
        warn(f"{metadata.where}: speaks of {stated} frames, the last in rgbd/ is {max(reader.frames)}: was the copy stopped?")


def write_frames(reader, numbers, work):
    """Numbers of the frames that were written, and how many of them have no confidence."""
    for name in ("rgb", "depth", "confidence"):
        (work / name).mkdir()
    written, faults, without, surest = [], [], 0, 0
    progress = Progress("reading")
    for count, number in enumerate(numbers, 1):
        progress(count, len(numbers))
        try:
            (end, picture), depth = reader.colour(number), reader.depth(number)
        except Damaged as fault:
            faults.append(str(fault))
            continue
        written.append(number)
        (work / f"rgb/{number}.{end}").write_bytes(picture)
        (work / f"depth/{number}.png").write_bytes(png(raw_of_metres(depth, UNITS_PER_M)))
        sure = reader.confidence(number)
        if sure is None:
            without += 1
        else:
            surest = max(surest, int(sure.max()))
            (work / f"confidence/{number}.png").write_bytes(png(sure))
    if 2 * len(written) < len(numbers):
        raise Refused(f"{reader.path}: {len(faults)} of {len(numbers)} frames cannot be used; the first: {faults[0]}; copy the recording again")
    tell(reader.path, faults, len(numbers))
    if not surest:
        # None, or 0 everywhere, which would leave nothing of depth.
        without = len(written)
        for file in (work / "confidence").iterdir():
            file.unlink()
        (work / "confidence").rmdir()
    return written, without


def import_record3d(path, options):
    reader = Reader(path)
    if options.list:
        fields = ", ".join(sorted(map(str, reader.metadata.written)))
        print(f"{len(reader.frames)} frames, colour {reader.metadata.size[0]} x {reader.metadata.size[1]}\nmetadata: {fields}")
        return
    numbers = sorted(reader.frames)[::options.every]
    with new_folder(options.folder) as work:
        written, without = write_frames(reader, numbers, work)
        (work / "metadata.json").write_text(json.dumps(reader.metadata.written, allow_nan=False))
        (work / "capture.yaml").write_text(f"format: record3d\ndepth_units_per_m: {UNITS_PER_M}\n")
    say_what_is_missing(reader, written, without)
    print(f"{options.folder}: {len(written)} frames", file=sys.stderr)
