"""What comes back of a training as one file. Weights and curves are packed before networks and scores are made: those take minutes,
and whoever ends the command meanwhile must not lose what was learnt. Every step that ended is kept and not made again."""
import os
import pathlib
import shutil
import subprocess
import tarfile
import time

MOST_BYTES = 16 * 2**20  # of one file that comes back
POLL_S = 0.1
END_S = 5  # for a step to end after it was told to


def pack(file, prefix, files, most=MOST_BYTES):
    """`files` under `prefix` in a tar that takes the place of the one before only when it is whole and small enough."""
    aside = file.with_name(file.name + ".partial")
    with tarfile.open(aside, "w") as tar:
        for part in files:
            tar.add(part, f"{prefix}/{part.name}")
    size = aside.stat().st_size
    if size > most:
        aside.unlink()
        raise SystemExit(f"{file}: {size / 2**20:.1f} MiB; a file that comes back has at most {most / 2**20:.0f}")
    aside.replace(file)
    print(f"{file}: {size / 2**20:.1f} MiB", flush=True)


class Steps:
    """Commands that each make one thing in `folder`, until `limit_s` are spent on all of them or somebody asks to stop."""

    def __init__(self, folder, limit_s, stopped, environment=None, before=None):
        """`stopped()`: whether somebody asked to. `before`: called in every process before its command."""
        self.folder, self.stopped, self.before = pathlib.Path(folder), stopped, before
        self.environment = dict(os.environ, **(environment or {}))
        self.end = time.monotonic() + limit_s

    def make(self, name, command):
        """Whether `name` is there. `command(place)`: what makes it at that place. A step that fails ends the program."""
        made = self.folder / name
        if made.exists():
            return True
        aside, log = self.folder / f"{name}.partial", self.folder / f"{name}.log"
        shutil.rmtree(aside, ignore_errors=True)
        aside.unlink(missing_ok=True)
        if self.is_over():
            return False
        start = time.monotonic()
        with open(log, "wb") as said:
            process = subprocess.Popen(command(aside), cwd=self.folder, stdout=said, stderr=said, env=self.environment,
                                       preexec_fn=self.before)
            while process.poll() is None and not self.is_over():
                time.sleep(POLL_S)
            if process.poll() is None:
                end(process)
        if process.returncode and self.is_over():
            return False
        if process.returncode:
            raise SystemExit(f"{name}: {log.read_text(encoding='utf-8', errors='replace').strip()[-1500:]}")
        aside.rename(made)
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
        return True

    def is_over(self):
        return self.stopped() or time.monotonic() >= self.end


def end(process):
    process.terminate()
    try:
        process.wait(END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
