"""What importers of recordings share: refusals, images, progress, folders that appear when they are whole."""
import contextlib
import os
import pathlib
import shutil
import struct
import sys
import tempfile
import zlib

try:
    import numpy
except ImportError:
    numpy = None  # help is to be had without

MAX_SIDE_PX = 16384


class Refused(Exception):
    """What is wrong with the recording or the call, for the user."""


def warn(text):
    print(f"warning: {text}", file=sys.stderr)


def png(pixels):
    """A PNG file of an array: 8 bits of grey, RGB, or 16 bits of grey."""
    kind, bits = (2, 8) if pixels.ndim == 3 else (0, 16 if pixels.dtype == numpy.uint16 else 8)
    height, width = pixels.shape[:2]
    rows = pixels.astype(">u2").view(numpy.uint8) if bits == 16 else pixels
    rows = rows.reshape(height, -1)
    # Each row begins with its filter: none.
    body = numpy.hstack([numpy.zeros((height, 1), numpy.uint8), rows]).tobytes()

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(body, 3)) + chunk(b"IEND", b"")


def raw_of_metres(metres, units_per_m):
    """Whole numbers of 16 bits; 0 where depth is none, or more than they hold."""
    units = numpy.nan_to_num(metres.astype(numpy.float64), nan=0, posinf=0, neginf=0) * units_per_m
    units[(units < 0.5) | (units > 65534)] = 0
    return numpy.rint(units).astype(numpy.uint16)


class Progress:
    def __init__(self, what):
        self.what, self.last = what, -1

    def __call__(self, done, total):
        percent = 100 * done // max(1, total)
        if percent == self.last or not sys.stderr.isatty():
            return
        self.last = percent
        print(f"\r{self.what} {percent:3d} %", end="\n" if done >= total else "", file=sys.stderr, flush=True)


@contextlib.contextmanager
def new_folder(target):
    """A folder to fill, which becomes `target` at the end; nothing of it is left where anything fails."""
    if target.exists():
        raise Refused(f"{target}: exists already; name a folder that does not")
    target.parent.mkdir(parents=True, exist_ok=True)
    # Beside the target, so that it can be renamed.
    work = pathlib.Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    try:
        yield work
        os.chmod(work, 0o755)
        os.rename(work, target)
    finally:
        shutil.rmtree(work, ignore_errors=True)
