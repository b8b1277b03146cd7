"""What can go wrong, as exceptions: each says where, what, and what to do about it."""
from __future__ import annotations

import os


class Error(Exception):
    """A file or a value that cannot be used.

    `file` is the file or folder, `field` the place in it (empty: the file as a whole), `problem` what is wrong with the value,
    quoting it, and `remedy` what to do. As text: `FILE: FIELD PROBLEM; REMEDY`.
    """

    def __init__(self, file: str | os.PathLike[str], field: str, problem: str, remedy: str) -> None:
        self.file = os.fspath(file)
        self.field = field
        self.problem = problem
        self.remedy = remedy
        place = f"{self.file}: {field} " if field else f"{self.file}: "
        super().__init__(f"{place}{problem}; {remedy}" if remedy else f"{place}{problem}")


class ProgramMissing(Error):
    """The program `deepslam` was not found."""


class ProgramError(Error):
    """The program ended with an error. `exit_code` is the program's own; negative: the signal that ended it.

    `message` is what the program said, whole.
    """

    def __init__(self, program: str | os.PathLike[str], command: str, exit_code: int, message: str) -> None:
        self.exit_code = exit_code
        self.message = message
        super().__init__(program, command, f"ended with exit code {exit_code}: {message}", "")


class RunFailed(ProgramError):
    """Failed while running: exit code 1, or the process crashed or was killed (a negative one)."""


class UsageError(ProgramError):
    """Wrong usage or configuration: exit code 2."""


class InputUnusable(ProgramError):
    """The capture or another input cannot be used: exit code 3."""


class Interrupted(ProgramError):
    """Stopped before the end: exit code 130. The same call goes on where it was."""


_BY_EXIT_CODE: dict[int, type[ProgramError]] = {2: UsageError, 3: InputUnusable, 130: Interrupted}


def program_error(program: str | os.PathLike[str], command: str, exit_code: int, message: str) -> ProgramError:
    """The exception that goes with an exit code."""
    return _BY_EXIT_CODE.get(exit_code, RunFailed)(program, command, exit_code, message)
