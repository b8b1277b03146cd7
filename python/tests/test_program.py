"""The program as it is called: its progress, its errors and exit codes, and how it is stopped. A stand-in plays its part."""
from __future__ import annotations

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest
from unittest import mock

import deepslam


class Program(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="deepslam-python-"))
        self.addCleanup(shutil.rmtree, self.folder, True)

    def stand_in(self, body: str) -> pathlib.Path:
        """A program that notes its arguments and goes on with `body`."""
        file = self.folder / "stand in"
        file.write_text(f"#!{sys.executable}\nimport json, os, pathlib, signal, sys, time\n"
                        f"pathlib.Path({str(self.folder)!r}, 'arguments').write_text(json.dumps(sys.argv[1:]))\n"
                        "def say(line): print(line, file=sys.stderr, flush=True)\n" + textwrap.dedent(body))
        file.chmod(0o755)
        return file

    def arguments(self) -> list[str]:
        arguments: list[str] = json.loads((self.folder / "arguments").read_text())
        return arguments

    RESULT = '{"format": "deepslam/run_result", "version": 1, "ran": ["track"], "skipped": ["ground"], "map": "ws/export/map.json"}'

    def test_a_run_tells_its_progress(self) -> None:
        program = self.stand_in(f"""
            say('warning: the capture has no poses')
            say('{{"event": "start", "stage": "track", "text": "missing"}}')
            say('{{  "event": "progress",  "stage": "track",  "text": "40/120" }}')
            say('warning: track: frame 7 is dark: a warning with a colon')
            say('{{"event": "done", "stage": "track", "text": "120 frames"}}')
            say('{{"event": "skipped", "stage": "ground", "text": "seen"}}')
            say('{{"event": "some", "brace": ')
            print('{self.RESULT}')
        """)
        events: list[deepslam.Progress] = []
        result = deepslam.run("a capture", "ws", {"detect.min_score": 0.4, "propose.network": True, "detect.source": "none"},
                              on_progress=events.append, poses="capture", until="loops", force=["track", "mesh"], threads=0,
                              config=[pathlib.Path("home.yaml")], program=program)
        self.assertEqual([(event.event, event.stage) for event in events],
                         [("warning", ""), ("start", "track"), ("progress", "track"), ("warning", "track"), ("done", "track"),
                          ("skipped", "ground")])
        self.assertEqual((events[2].done, events[2].total), (40, 120))
        self.assertEqual(result.warnings, ("the capture has no poses", "track: frame 7 is dark: a warning with a colon"))
        self.assertEqual((result.ran, result.skipped, result.scene_glb), (("track",), ("ground",), None))
        self.assertEqual(result.map_json, pathlib.Path("ws/export/map.json"))
        self.assertEqual(self.arguments(), [
            "run", "a capture", "--output", "ws", "--progress", "json", "--config", "home.yaml", "--set", "detect.min_score=0.4",
            "--set", "propose.network=true", "--set", "detect.source=none", "--poses", "capture", "--until", "loops", "--force", "track",
            "--force", "mesh", "--threads", "0"])

    def test_errors_keep_message_and_exit_code(self) -> None:
        for code, kind in ((1, deepslam.RunFailed), (2, deepslam.UsageError), (3, deepslam.InputUnusable), (130, deepslam.Interrupted),
                           (77, deepslam.RunFailed)):
            program = self.stand_in(f"""
                say('info: reading')
                say('error: rgb.txt: line 3 is "x"; repair it')
                say('  and line 4')
                sys.exit({code})
            """)
            with self.assertRaises(kind) as caught:
                deepslam.run("c", "w", program=program)
            self.assertEqual(caught.exception.exit_code, code)
            self.assertEqual(caught.exception.message, 'rgb.txt: line 3 is "x"; repair it\n  and line 4')
            self.assertIsInstance(caught.exception, deepslam.Error)
        # CLI's own complaints have no level before them; what was said last is told.
        with self.assertRaises(deepslam.UsageError) as usage:
            deepslam.run("c", "w", program=self.stand_in("say('--poses: x not in {track}')\nsys.exit(2)"))
        self.assertEqual(usage.exception.message, "--poses: x not in {track}")

    def test_a_crash_is_no_success(self) -> None:
        with self.assertRaises(deepslam.RunFailed) as caught:
            deepslam.run("c", "w", program=self.stand_in("os.kill(os.getpid(), signal.SIGSEGV)"))
        self.assertEqual(caught.exception.exit_code, -signal.SIGSEGV)

    def test_a_result_that_is_none(self) -> None:
        for text in ("", "{", '{"format": "deepslam/run_result", "version": 2}'):
            with self.assertRaises(deepslam.Error):
                deepslam.run("c", "w", program=self.stand_in(f"print({text!r})"))

    def test_much_output_does_not_hold_it_up(self) -> None:
        program = self.stand_in(f"""
            for n in range(20000): say('info: ' + 60 * 'x')
            print('{self.RESULT[:-1]}, "more": "' + 300000 * 'y' + '"}}')
        """)
        self.assertEqual(deepslam.run("c", "w", program=program).ran, ("track",))

    # Its fourth argument is what follows --output.
    STOPS = """
        def stop(*_):
            for n in range(3000): say('info: ' + 60 * 'x')  # more than a pipe holds
            pathlib.Path(sys.argv[4]).write_text('stopped well')
            sys.exit(130)
        signal.signal(signal.SIGINT, stop)
        say('{"event": "start", "stage": "track", "text": ""}')
        time.sleep(60)
    """

    def test_an_exception_of_the_listener_stops_the_program_and_goes_on(self) -> None:
        class Enough(Exception):
            pass

        def listen(_: deepslam.Progress) -> None:
            raise Enough

        before = time.monotonic()
        mark = self.folder / "mark"
        with self.assertRaises(Enough):
            deepslam.run("c", mark, on_progress=listen, program=self.stand_in(self.STOPS))
        self.assertEqual(mark.read_text(), "stopped well")
        self.assertLess(time.monotonic() - before, 30)

    def test_ctrl_c_stops_the_program(self) -> None:
        mark = self.folder / "mark"
        program = self.stand_in(self.STOPS)
        script = f"import deepslam; deepslam.run('c', {str(mark)!r}, on_progress=lambda e: print(e.event, flush=True), program={str(program)!r})"
        source = pathlib.Path(deepslam.__file__).parents[1]
        with subprocess.Popen([sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": str(source)}, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as process:
            assert process.stdout and process.stderr
            self.assertEqual(process.stdout.readline(), "start\n")
            process.send_signal(signal.SIGINT)
            self.assertIn("KeyboardInterrupt", process.stderr.read())
            self.assertNotEqual(process.wait(60), 0)
        self.assertEqual(mark.read_text(), "stopped well")

    def test_where_the_program_is_looked_for(self) -> None:
        one = self.stand_in("")
        bin_folder = self.folder / "bin"
        bin_folder.mkdir()
        in_path = shutil.copy(one, bin_folder / "deepslam")
        with mock.patch.dict(os.environ, {"PATH": str(bin_folder), "DEEPSLAM": ""}):
            self.assertEqual(deepslam.find_program(), pathlib.Path(in_path))
            with mock.patch.dict(os.environ, {"DEEPSLAM": str(one)}):
                self.assertEqual(deepslam.find_program(), one)
                self.assertEqual(deepslam.find_program(in_path), pathlib.Path(in_path))
                with self.assertRaisesRegex(deepslam.ProgramMissing, "nowhere: is no program that can be run; give its file"):
                    deepslam.find_program(self.folder / "nowhere")
            (bin_folder / "deepslam").unlink()
            with self.assertRaisesRegex(deepslam.ProgramMissing, "deepslam: was not found; .*DEEPSLAM"):
                deepslam.find_program()


class Expand(unittest.TestCase):
    def test_a_map_alone_is_expanded(self) -> None:
        import handmade

        with tempfile.TemporaryDirectory(prefix="deepslam-python-") as name:
            folder = pathlib.Path(name)
            (folder / "map.json").write_text(json.dumps(handmade.compact_map()))
            (folder / "whole.glb").write_bytes(handmade.scene_glb())
            program = folder / "deepslam"
            program.write_text(f'#!/bin/sh\n[ "$5" = --uncompressed ] && cp "{folder}/whole.glb" "$4"\n')
            program.chmod(0o755)
            scene = deepslam.open(folder / "map.json", program=program)
            self.assertAlmostEqual(scene.object("chair_00").mesh.volume_m3, 0.24, places=5)
            program.write_text('#!/bin/sh\necho "error: no furniture library; deepslam library build makes it" >&2\nexit 3\n')
            with self.assertRaisesRegex(deepslam.InputUnusable, "no furniture library"):
                deepslam.open(folder / "map.json", program=program).meshes
