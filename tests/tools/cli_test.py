#!/usr/bin/env python3
"""Exit codes and messages of the command line.

    cli_test.py DEEPSLAM REPOSITORY
"""
import fcntl
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zipfile

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
REPOSITORY = pathlib.Path(sys.argv[2]).resolve()


def run(*arguments, data=None):
    environment = dict(os.environ, DEEPSLAM_DATA=str(data) if data else "/nonexistent")
    return subprocess.run([PROGRAM, *(a if isinstance(a, bytes) else str(a) for a in arguments)], capture_output=True, text=True, timeout=600, env=environment)


def glb(document):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text


EMPTY_MAP = {"format": "deepslam/map", "version": 4, "tool_version": "0", "capture_name": "", "capture_hash": "",
             "ground_outline_m": [], "class_colours": {}, "mesh_options": {}, "verdict": "bad", "reasons": [], "objects": []}


class CommandLine(unittest.TestCase):
    def setUp(self):
        self.temp = tempfile.TemporaryDirectory(prefix="deepslam-cli-")
        self.dir = pathlib.Path(self.temp.name)

    def tearDown(self):
        self.temp.cleanup()

    def check(self, result, code, *texts):
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        for text in texts:
            self.assertIn(text, result.stderr)

    def test_wrong_usage_is_2(self):
        self.check(run(), 2)
        self.check(run("rnu"), 2)
        self.check(run("run"), 2, "CAPTURE")
        self.check(run("run", "x", "-o", "y", "--threads", "-3"), 2)
        self.check(run("run", "x", "-o", "y", "--poses", "guess"), 2)
        self.check(run("run", "x", "-o", self.dir / "w", "--set", "trak.max_depth_m=3"), 2, "unknown option")
        self.check(run("run", "x", "-o", self.dir / "w", "--config", self.dir / "none.yaml"), 2, "none.yaml")
        self.assertFalse((self.dir / "w").exists(), "nothing may be made of a wrong command")

    def test_a_word_that_is_no_command_gets_the_nearest_one(self):
        self.check(run("runn", "capture"), 2, "runn is no command, did you mean run?")
        self.check(run("photogrammetry"), 2, "photogrammetry is no command; ")

    def test_help_and_version(self):
        self.assertEqual(run("--help").returncode, 0)
        self.assertIn("run", run("--help").stdout)
        self.assertRegex(run("version").stdout, r"^deepslam \d+\.\d+\.\d+\n$")

    def test_missing_capture_is_3(self):
        result = run("run", self.dir / "none", "-o", self.dir / "w")
        self.check(result, 3, "none")
        self.assertFalse((self.dir / "w").exists())

    def test_empty_capture_is_3(self):
        (self.dir / "empty").mkdir()
        self.check(run("run", self.dir / "empty", "-o", self.dir / "w"), 3)

    def test_config_dump_is_the_file_and_checks_clean(self):
        dump = run("config", "dump")
        self.assertEqual(dump.returncode, 0)
        self.assertEqual(dump.stdout, (REPOSITORY / "configs" / "default.yaml").read_text())
        for name in ("default.yaml", "paper.yaml"):
            self.check(run("config", "check", REPOSITORY / "configs" / name), 0)

    def test_config_check_tells_all_faults(self):
        file = self.dir / "mine.yaml"
        file.write_text("track:\n  keyframe_distnace_m: 1\ndetect:\n  source: telepathy\n")
        result = run("config", "check", file)
        self.check(result, 2, "mine.yaml:2", "did you mean track.keyframe_distance_m?", "mine.yaml:4", "telepathy")

    def test_doctor_tells_what_is_missing(self):
        result = run("doctor", data=self.dir)
        self.check(result, 3, "MISSING", "scripts/setup.sh")
        findings = {row["what"]: row["ok"] for row in json.loads(result.stdout)["findings"]}
        self.assertFalse(findings["detector weights"])
        self.assertTrue(findings["classes"])

    def test_doctor_tells_which_shape_networks_there_are(self):
        def networks(*options):
            result = run("doctor", *options, data=self.dir)
            return {row["what"]: row for row in json.loads(result.stdout)["findings"]}["shape networks"]

        self.assertIn("propose.network", networks("--set", "propose.network=false")["detail"])
        there = networks("--set", "propose.network=true")
        self.assertTrue(there["ok"])
        self.assertRegex(there["detail"], "chair.* in .*priors")
        missing = networks("--set", "propose.network=true", "--set", f"propose.priors={self.dir / 'none'}")
        self.assertFalse(missing["ok"])
        self.assertIn("train.sh", missing["detail"])

    def test_status_of_no_workspace_is_3(self):
        self.check(run("status", self.dir / "none"), 3)
        (self.dir / "photos").mkdir()
        (self.dir / "photos" / "cat.jpg").write_text("miau")
        self.check(run("status", self.dir / "photos"), 3, "no workspace")

    def test_validate_refuses_what_is_no_glb(self):
        file = self.dir / "x.glb"
        file.write_bytes(b"glTF but not really")
        result = run("validate", file)
        self.check(result, 1)
        self.assertFalse(json.loads(result.stdout)["ok"])
        self.check(run("validate", self.dir / "none.glb"), 3)

    def test_validate_names_the_place_of_the_damage(self):
        whole = glb({"asset": {"version": "2.0"}})
        file = self.dir / "scene.glb"
        file.write_bytes(whole)
        self.check(run("validate", file), 0)  # foreign and without objects, but sound
        file.write_bytes(whole[:-4])
        self.check(run("validate", file), 1, "header: length", "truncated or damaged")
        file.write_bytes(glb({"asset": {"version": "2.0"}, "nodes": [{"mesh": 7}]}))
        self.check(run("validate", file), 1, "nodes[0].mesh: is 7 of 0")

    def test_validate_holds_a_scene_against_its_map(self):
        file, beside = self.dir / "scene.glb", self.dir / "map.json"
        chair = {"name": "chair_04", "extras": {"class": "chair", "instance": 4}}
        file.write_bytes(glb({"asset": {"version": "2.0"}, "nodes": [chair], "scenes": [{"nodes": [0]}]}))
        beside.write_text(json.dumps(EMPTY_MAP))
        result = run("validate", file)  # finds the map by itself
        self.check(result, 1, "object 4 ('chair_04') of the scene is not in the map")
        self.assertFalse(json.loads(result.stdout)["ok"])
        beside.write_text("{")
        self.check(run("validate", file), 3, "map.json")
        self.check(run("validate", file, "--map", self.dir / "none.json"), 3, "none.json")

    def test_expand_refuses_what_is_no_map(self):
        file, scene = self.dir / "map.json", self.dir / "out.glb"
        for content, pattern in [
                (glb({"asset": {"version": "2.0"}}), "is a glTF scene already"),
                (b"", "map.json"),
                (json.dumps(EMPTY_MAP).encode()[:-20], "map.json: not valid JSON: parse error at line 1"),
                (b'{"format": "deepslam/other", "version": 1}', 'map.json: format is not "deepslam/map"'),
                (json.dumps(dict(EMPTY_MAP, version=99)).encode(), "99"),
                (json.dumps(dict(EMPTY_MAP, ground_outline_m=[0, 1, 2])).encode(), "ground_outline_m must hold x and y in turn"),
                (json.dumps(dict(EMPTY_MAP, verdict="lovely")).encode(), "verdict")]:
            file.write_bytes(content)
            self.check(run("expand", file, "-o", scene), 3, pattern)
            self.assertFalse(scene.exists(), "nothing may be written")
        file.write_text(json.dumps(EMPTY_MAP))
        for name in ("out.stl", "out"):
            self.check(run("expand", file, "-o", self.dir / name), 2, name + ": is no scene that is written")
            self.assertFalse((self.dir / name).exists())
        self.check(run("expand", file, "-o", scene), 0)
        self.check(run("validate", scene, "--map", file), 0)

    def test_eval_trajectory(self):
        lines = [f"{i / 10} {i * 0.1} {i * i * 0.01} 0 0 0 0 1" for i in range(20)]
        truth = self.dir / "truth.tum"
        truth.write_text("\n".join(lines))
        result = run("eval", "trajectory", truth, truth)
        self.check(result, 0, "20 of 20 frames scored")
        self.assertLess(json.loads(result.stdout)["ate_m"]["rmse"], 1e-9)
        self.check(run("eval", "trajectory", truth, truth, "--rpe-delta", "20"), 3, "--rpe-delta 20")
        self.check(run("eval", "trajectory", truth, truth, "--max-time-difference", "nan"), 2, "nan")
        bad = self.dir / "bad.tum"
        bad.write_text("0 0 0 0\n")
        self.check(run("eval", "trajectory", bad, truth), 3, "bad.tum:1")


def make_catalogue(file, *items):
    """A Sweet Home 3D catalogue of boxes: (id, name, width, depth, height in cm)."""
    quads = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    faces = "".join("f {} {} {} {}\n".format(*q) for q in quads)
    lines = ["name=Boxes", "license=free"]
    with zipfile.ZipFile(file, "w") as archive:
        for n, (name_id, name, *sides) in enumerate(items, 1):
            lines += [f"id#{n}={name_id}", f"name#{n}={name}", f"model#{n}=/m/{n}.obj", f"creator#{n}=nobody"]
            lines += [f"{key}#{n}={side}" for key, side in zip(("width", "depth", "height"), sides)]
            width, depth, height = sides
            corners = [(x, y, z) for x in (0, width) for y in (0, height) for z in (0, depth)]
            archive.writestr(f"m/{n}.obj", "".join("v {} {} {}\n".format(*c) for c in corners) + faces)
        archive.writestr("PluginFurnitureCatalog.properties", "\n".join(lines) + "\n")


class Libraries(unittest.TestCase):
    def setUp(self):
        self.temp = tempfile.TemporaryDirectory(prefix="deepslam-cli-")
        self.dir = pathlib.Path(self.temp.name)
        self.catalogues = self.dir / "catalogues"
        self.catalogues.mkdir()
        make_catalogue(self.catalogues / "boxes.sh3f", ("B#cabinet", "Cabinet", 80, 40, 90), ("B#desk", "Desk", 140, 70, 74))

    def tearDown(self):
        self.temp.cleanup()

    def build(self):
        result = run("library", "build", "--catalogues", self.catalogues, "--withheld", self.dir / "list.yaml",
                     "-o", self.dir / "library")
        self.assertEqual(result.returncode, 0, result.stderr)
        models = json.loads((self.dir / "library" / "library.json").read_text())["models"]
        return "up to date" in result.stderr, [model["id"] for model in models]

    def test_library_is_made_again_when_the_list_of_withheld_products_changes(self):
        withheld = self.dir / "list.yaml"
        withheld.write_text("withheld:\n")
        self.assertEqual(self.build()[0], False)
        withheld.write_text("# the same list, written anew\nwithheld:\n")
        self.assertTrue(self.build()[0])
        # A box is like every other box: withholding one keeps both out, by id and by shape.
        withheld.write_text('withheld:\n  - id: "B#desk"\n')
        self.assertEqual(self.build(), (False, []))

    def test_split_prints_a_list_that_build_reads(self):
        result = run("library", "split", "--catalogues", self.catalogues, "--share", "1")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn('- id: "B#cabinet"', result.stdout)
        self.assertIn('- id: "B#desk"', result.stdout)
        (self.dir / "list.yaml").write_text(result.stdout)
        self.assertEqual(self.build()[1], [])
        self.assertEqual(run("library", "split", "--catalogues", self.catalogues, "--share", "2").returncode, 2)


class Workspaces(unittest.TestCase):
    """Needs a capture that opens: three tiny frames."""

    @classmethod
    def setUpClass(cls):
        cls.temp = tempfile.TemporaryDirectory(prefix="deepslam-cli-")
        cls.dir = pathlib.Path(cls.temp.name)
        cls.capture = cls.dir / "capture"
        make_capture(cls.capture)

    @classmethod
    def tearDownClass(cls):
        cls.temp.cleanup()

    def run_capture(self, workspace, *more, until="track"):
        return run("run", self.capture, "-o", workspace, "--until", until, "--poses", "capture", "--progress", "none",
                   "--set", "detect.source=none", "--set", "propose.retrieval=false", *more)

    def test_explain_and_resume(self):
        workspace = self.dir / "resume"
        first = self.run_capture(workspace, "--explain")
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertIn("missing", first.stderr)
        second = self.run_capture(workspace, "--explain", "--threads", "1")
        self.assertEqual(json.loads(second.stdout)["ran"], [])
        third = self.run_capture(workspace, "--explain", "--set", "track.keyframe_distance_m=0.345")
        self.assertEqual(json.loads(third.stdout)["ran"], ["track"])
        self.assertRegex(third.stderr, r"option track\.keyframe_distance_m [\d.]+ -> 0\.345")
        status = run("status", workspace)
        self.assertEqual(status.returncode, 0, status.stderr)
        states = {row["stage"]: row["state"] for row in json.loads(status.stdout)["stages"]}
        self.assertEqual(states["track"], "done")
        self.assertEqual(states["export"], "missing")

    def test_a_run_that_ends_before_names_no_scene(self):
        workspace = self.dir / "ends_before"
        self.assertEqual(self.run_capture(workspace).returncode, 0)
        (workspace / "export").mkdir()
        (workspace / "export" / "scene.glb").write_bytes(b"of an earlier run")
        self.assertNotIn("scene", json.loads(self.run_capture(workspace).stdout))

    def test_status_sees_overrides_that_wait(self):
        workspace = self.dir / "waits"
        self.assertEqual(self.run_capture(workspace, until="ground").returncode, 0)

        def state(stage):
            rows = json.loads(run("status", workspace).stdout)["stages"]
            return next(row["state"] for row in rows if row["stage"] == stage)
        self.assertEqual(state("ground"), "done")
        (workspace / "overrides.yaml").write_text("ground: {up_camera: [0, -1, 0], height_m: 1.2}\n")
        self.assertEqual(state("ground"), "stale", run("status", workspace).stderr)

    def test_a_name_that_is_no_utf8(self):
        capture = os.fsencode(self.dir) + b"/k\xfcche"
        shutil.copytree(os.fsencode(self.capture), capture)
        workspace = os.fsencode(self.dir) + b"/w\xfc"
        result = run("run", capture, "-o", workspace, "--until", "track", "--poses", "capture", "--progress", "none",
                     "--set", "detect.source=none", "--set", "propose.retrieval=false")
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_missing_weights_are_3(self):
        result = run("run", self.capture, "-o", self.dir / "weights")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("scripts/setup.sh", result.stderr)
        self.assertIn("deepslam doctor", result.stderr)

    def test_workspace_that_cannot_be_written_is_1(self):
        result = self.run_capture("/proc/deepslam")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("/proc/deepslam", result.stderr)

    def test_locked_workspace_is_1(self):
        workspace = self.dir / "locked"
        self.assertEqual(self.run_capture(workspace).returncode, 0)
        with open(workspace / ".lock", "r+") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            result = self.run_capture(workspace)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("another run", result.stderr)

    def test_workspace_of_another_version_is_3(self):
        workspace = self.dir / "future"
        self.assertEqual(self.run_capture(workspace).returncode, 0)
        (workspace / "workspace.json").write_text('{"format": "deepslam/workspace", "version": 99}')
        result = self.run_capture(workspace)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("newer deepslam", result.stderr)


def make_capture(folder):
    """Three frames of a textured wall, 64 x 48, written without any package: PPM colour, 16-bit PGM depth."""
    import struct
    import zlib

    def png(path, width, height, bit_depth, colour_type, rows):
        def chunk(kind, payload):
            return struct.pack(">I", len(payload)) + kind + payload + struct.pack(">I", zlib.crc32(kind + payload))
        header = struct.pack(">IIBBBBB", width, height, bit_depth, colour_type, 0, 0, 0)
        raw = b"".join(b"\0" + row for row in rows)
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw)) +
                         chunk(b"IEND", b""))

    width, height = 64, 48
    (folder / "rgb").mkdir(parents=True)
    (folder / "depth").mkdir()
    pairs, poses = [], []
    for i in range(3):
        rows = [bytes(((u * 7 + v * 13 + c * 29 + i) % 256) for u in range(width) for c in range(3)) for v in range(height)]
        png(folder / "rgb" / f"{i}.png", width, height, 8, 2, rows)
        depth = [struct.pack(f">{width}H", *[2000 + 5 * ((u + v + i) % 40) for u in range(width)]) for v in range(height)]
        png(folder / "depth" / f"{i}.png", width, height, 16, 0, depth)
        pairs.append(f"{i / 10} rgb/{i}.png {i / 10} depth/{i}.png")
        poses.append(f"{i / 10} {0.01 * i} 0 0 0 0 0 1")
    (folder / "associations.txt").write_text("\n".join(pairs) + "\n")
    (folder / "groundtruth.txt").write_text("\n".join(poses) + "\n")
    (folder / "capture.yaml").write_text(
        "format: tum\ncamera: {width: 64, height: 48, fx: 60, fy: 60, cx: 31.5, cy: 23.5}\ndepth_units_per_m: 1000\n")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
