"""The program `deepslam`: found, run on captures with its progress told, and asked for meshes."""
from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import IO, Any

from .documents import read_document
from .errors import Error, ProgramMissing, program_error

VARIABLE = "DEEPSLAM"
_LEVELS = ("error", "warning", "info", "debug")
StrPath = str | os.PathLike[str]


@dataclasses.dataclass(frozen=True)
class Progress:
    """What a run tells while it works.

    `event` is `start`, `progress`, `done` or `skipped` (unchanged since an earlier run) of a stage, or `warning`; `text` is the
    program's own: why the stage runs, what came out, what the warning is. `done` of `total` steps with `progress`, else None.
    """

    event: str  # start, progress, done, skipped, warning
    stage: str  # that it is about; empty: none yet
    text: str  # the program's own words
    done: int | None = None  # steps
    total: int | None = None  # steps


@dataclasses.dataclass(frozen=True)
class RunResult:
    """What a run came to: stages that ran and those that were left as they were, files that it made, warnings."""

    workspace: pathlib.Path  # what `open` opens
    ran: tuple[str, ...]  # stages, in order
    skipped: tuple[str, ...]  # stages whose files were those of this run already
    scene_glb: pathlib.Path | None  # the scene; None where the run ended before (`until`)
    map_json: pathlib.Path | None  # the compact map
    report_html: pathlib.Path | None  # the report
    warnings: tuple[str, ...]  # as they were said


def find_program(program: StrPath | None = None) -> pathlib.Path:
    """The file of the program: `program`, else what the variable DEEPSLAM of the environment names, else `deepslam` in PATH."""
    named = program if program is not None else os.environ.get(VARIABLE) or None
    remedy = f"give its file as `program`, name it in the variable {VARIABLE}, or put it in PATH (docs/installing.md)"
    found = shutil.which(os.fspath(named) if named is not None else "deepslam")
    if found is None:
        what = "the program deepslam" if named is None else os.fspath(named)
        raise ProgramMissing(what, "", "is no program that can be run" if named is not None else "was not found", remedy)
    return pathlib.Path(found)


def run(
    capture: StrPath,
    workspace: StrPath,
    options: Mapping[str, object] | None = None,
    *,
    on_progress: Callable[[Progress], None] | None = None,
    config: Sequence[StrPath] = (),
    poses: str | None = None,
    overrides: StrPath | None = None,
    until: str | None = None,
    force: Sequence[str] = (),
    threads: int | None = None,
    data: StrPath | None = None,
    program: StrPath | None = None,
) -> RunResult:
    """Takes a capture through the chain, as `deepslam run` does, and waits for the end; continues where it was stopped.

        result = deepslam.run("capture", "workspace", {"export.trajectory": False},
                              on_progress=lambda event: print(event.stage, event.text))
        print(result.ran, result.warnings)

    `options` are those of `deepslam config dump`, by name: {"detect.min_score": 0.4}. The others are the program's own
    (`deepslam run --help`). `on_progress` is called in this thread for every event. An exception of it, and Ctrl-C, stop the
    program between two steps; what is done stays. Raises `ProgramError` and `ProgramMissing`.
    """
    found = find_program(program)
    command = [str(found), "run", os.fspath(capture), "--output", os.fspath(workspace), "--progress", "json"]
    command += _flags({
        "--config": config, "--set": [f"{name}={_option_text(value)}" for name, value in (options or {}).items()],
        "--poses": _maybe(poses), "--overrides": _maybe(overrides), "--until": _maybe(until), "--force": force,
        "--threads": _maybe(threads), "--data": _maybe(data)})
    listener = _Listener(on_progress)
    with tempfile.TemporaryDirectory(prefix="deepslam-") as folder:
        told = pathlib.Path(folder) / "result of deepslam run"
        with told.open("wb") as result:
            code = _follow(command, result, listener)
        if code != 0:
            raise program_error(found, "run", code, listener.message())
        return _read_result(told, pathlib.Path(workspace), listener.warnings)


def expand(map_json: StrPath, scene_glb: StrPath, *, library: StrPath | None = None, data: StrPath | None = None,
           compressed: bool = False, program: StrPath | None = None) -> None:
    """Makes the scene again from the compact map alone, as `deepslam expand` does; uncompressed, so that it can be read here."""
    found = find_program(program)
    command = [str(found), "expand", os.fspath(map_json), "--output", os.fspath(scene_glb)]
    command += [] if compressed else ["--uncompressed"]
    command += _flags({"--library": _maybe(library), "--data": _maybe(data)})
    listener = _Listener(None)
    code = _follow(command, subprocess.DEVNULL, listener)
    if code != 0:
        raise program_error(found, "expand", code, listener.message())


def _maybe(value: StrPath | int | None) -> list[StrPath]:
    return [] if value is None else [value if isinstance(value, os.PathLike) else str(value)]


def _flags(values: Mapping[str, Sequence[StrPath]]) -> list[str]:
    """Each flag once for every value of its list."""
    return [word for flag, row in values.items() for value in row for word in (flag, os.fspath(value))]


def _option_text(value: object) -> str:
    """As YAML has it, which is what the program reads."""
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    return json.dumps(value)


class _Listener:
    """Takes the lines of a run's standard error: events, and what is said to people."""

    def __init__(self, on_progress: Callable[[Progress], None] | None) -> None:
        self.on_progress = on_progress
        self.warnings: list[str] = []
        self._errors: list[str] = []
        self._others: list[str] = []
        self._level = ""
        self._stage = ""

    def take(self, line: str) -> None:
        if line.startswith("{") and (event := _event(line)) is not None:
            self._stage = event.stage
            self._tell(event)
            return
        level, separator, text = line.partition(": ")
        if separator and level in _LEVELS:
            self._level = level
        else:
            text = line
            if self._level == "error":  # a message of several lines
                self._errors.append(text)
                return
        if self._level == "error":
            self._errors.append(text)
        elif separator and level == "warning":
            self.warnings.append(text)
            self._tell(Progress("warning", self._stage, text))
        else:
            self._others = [*self._others[-9:], text]

    def _tell(self, event: Progress) -> None:
        if self.on_progress is not None:
            self.on_progress(event)

    def message(self) -> str:
        """Why the program ended: its errors, else the last that it said."""
        return "\n".join(self._errors or self._others).strip() or "it said nothing"


def _event(line: str) -> Progress | None:
    try:
        value: Any = json.loads(line)
        done, total = None, None
        if value["event"] == "progress":
            done, total = map(int, value["text"].split("/"))
        return Progress(str(value["event"]), str(value["stage"]), str(value["text"]), done, total)
    except (ValueError, KeyError, TypeError, AttributeError):
        return None


def _follow(command: Sequence[str], stdout: IO[bytes] | int, listener: _Listener) -> int:
    """Runs the command, gives its lines to the listener, and returns its exit code."""
    # A process group of its own: Ctrl-C on a terminal comes here alone, and is passed on once.
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=stdout, stderr=subprocess.PIPE, encoding="utf-8",
                               errors="replace", process_group=0)
    assert process.stderr is not None
    try:
        for line in process.stderr:
            listener.take(line.rstrip("\n"))
        return process.wait()
    except BaseException:
        _stop(process, process.stderr)
        raise
    finally:
        process.stderr.close()


def _stop(process: subprocess.Popen[str], lines: Iterable[str]) -> None:
    process.send_signal(signal.SIGINT)
    for _ in lines:  # a full pipe would hold it up
        pass
    process.wait()


def _read_result(file: pathlib.Path, workspace: pathlib.Path, warnings: list[str]) -> RunResult:
    root = read_document(file, "deepslam/run_result", 1)
    files: dict[str, pathlib.Path | None] = {}
    for name in ("scene", "map", "report"):
        node = root.maybe(name)
        files[name] = pathlib.Path(node.text()) if node else None
    return RunResult(workspace, root["ran"].texts(), root["skipped"].texts(), files["scene"], files["map"], files["report"],
                     tuple(warnings))


