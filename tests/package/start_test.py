#!/usr/bin/env python3
"""What the program loads at its start. Image and video libraries of OpenCV bring two hundred others (GDAL, FFmpeg,
GStreamer) and a quarter of a second to every call: images are decoded without them, videos by a module that is loaded
when one is opened.

    start_test.py DEEPSLAM
"""
import pathlib
import re
import subprocess
import sys
import unittest

PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
HEAVY = ("libopencv_imgcodecs", "libopencv_videoio", "libopencv_highgui", "libgdal", "libavcodec", "libgst", "libOpen3D", "libvtk")


def libraries(file):
    told = subprocess.run(["ldd", str(file)], capture_output=True, text=True, timeout=120, check=True).stdout
    return re.findall(r"^\s*(\S+)", told, re.M)


class Start(unittest.TestCase):
    def test_no_heavy_library_is_loaded(self):
        loaded = libraries(PROGRAM)
        self.assertIn("libopencv_core", " ".join(loaded))
        self.assertEqual([name for name in loaded if name.startswith(HEAVY)], [])
        self.assertLess(len(loaded), 90)

    def test_the_module_that_reads_videos_lies_where_the_program_finds_it(self):
        module = PROGRAM.parent / "../lib/deepslam/libdeepslam_video.so"
        self.assertTrue(module.is_file(), module)
        self.assertIn("libopencv_videoio", " ".join(libraries(module)))


if __name__ == "__main__":
    unittest.main()
