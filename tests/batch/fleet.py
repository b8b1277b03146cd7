"""Forty small captures, six of them broken in different ways, and what single runs make of the others."""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "end_to_end"))
import captures  # noqa: E402

NUM_GOOD = 34
FRAMES_EACH = 8
FRAMES_OF_THE_CRASHING = 44
SCENE = captures.SCENE.replace("frames: 10", f"frames: {NUM_GOOD + FRAMES_EACH + 4}").replace("sweep_deg: 25", "sweep_deg: 110")
SCENE = SCENE.replace("width: 320, height: 240, fx: 262.5, fy: 262.5, cx: 159.5, cy: 119.5",
                      "width: 160, height: 120, fx: 131.25, fy: 131.25, cx: 79.5, cy: 59.5")
# Times, who held the workspace last, and what nobody compares.
NOT_COMPARED = {"timing.json", "timing.html", ".lock"}


def render(program, folder):
    """The room that all captures are cut from. None where the furniture catalogues are not installed."""
    scene = folder.with_suffix(".yaml")
    scene.write_text(SCENE)
    made = captures.deepslam(program, "synth", scene, "-o", folder, timeout=300)
    if made.returncode == 3 and "sweethome3d-furniture" in made.stderr:
        return None
    assert made.returncode == 0, made.stderr
    return folder


def cut(room, folder, first, count):
    """A capture of some of the room's frames, by links to its images."""
    folder.mkdir(parents=True)
    for name in ("rgb", "depth"):
        (folder / name).symlink_to(room / name)
    shutil.copy(room / "capture.yaml", folder / "capture.yaml")
    shutil.copy(room / "groundtruth.txt", folder / "groundtruth.txt")
    lines = [line for line in (room / "associations.txt").read_text().splitlines() if not line.startswith("#")]
    (folder / "associations.txt").write_text("\n".join(lines[first:first + count]) + "\n")
    return folder


class Fleet:
    """`good`: names; `broken`: name -> part of the reason it must be given. `crash` is a sound capture whose process the
    test kills."""

    def __init__(self, room, folder, with_crash=True):
        self.folder = folder
        self.good = [f"room_{i:02}" for i in range(NUM_GOOD)]
        for i, name in enumerate(self.good):
            cut(room, folder / name, i, FRAMES_EACH)
        self.broken = {"no_camera": "capture.yaml", "empty": "empty", "missing": "missing", "bad_number": "capture.yaml:2",
                       "no_depth": "depth", "crash": "crashed"}
        (cut(room, folder / "no_camera", 0, FRAMES_EACH) / "capture.yaml").unlink()
        (folder / "empty").mkdir()
        settings = cut(room, folder / "bad_number", 0, FRAMES_EACH) / "capture.yaml"
        settings.write_text("format: tum\ncamera: {width: 160, height: 120, fx: wide, fy: 131.25, cx: 79.5, cy: 59.5}\n")
        dark = cut(room, folder / "no_depth", 0, FRAMES_EACH)
        (dark / "depth").unlink()
        (dark / "depth").mkdir()
        for file in sorted((room / "depth").iterdir())[:FRAMES_EACH]:
            captures.write_depth(dark / "depth" / file.name, 160, 120, 0)
        if with_crash:
            cut(room, folder / "crash", 0, FRAMES_OF_THE_CRASHING)
        # The one that crashes goes first: it is the longest.
        self.names = ["crash", *self.good[:10], "no_camera", "empty", *self.good[10:20], "missing", "bad_number",
                      *self.good[20:], "no_depth"]
        self.list = folder / "list.txt"
        self.list.write_text("# all rooms\n" + "".join(f"{name}   # {i}\n" for i, name in enumerate(self.names)))


def digests(workspace):
    found = {}
    for path in sorted(workspace.rglob("*")):
        if path.is_file() and path.name not in NOT_COMPARED:
            found[str(path.relative_to(workspace))] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def single_runs(program, fleet, folder, options, timeout):
    """What `deepslam run` makes of each good capture, two at a time: name -> digests."""
    def one(name):
        result = captures.deepslam(program, "run", fleet.folder / name, "-o", folder / name, "--threads", "1", "--progress",
                                   "none", *options, timeout=timeout)
        assert result.returncode == 0, f"{name}: {result.stderr}"
        return digests(folder / name)
    with concurrent.futures.ThreadPoolExecutor(max(1, min(2, os.cpu_count() or 1))) as pool:
        return dict(zip(fleet.good, pool.map(one, fleet.good)))


def batch_json(root):
    """The state of a batch, or None before its first. It is written in one piece: half a file is a fault."""
    try:
        return json.loads((root / "batch.json").read_text())
    except FileNotFoundError:
        return None


def by_name(batch):
    return {row["name"]: row for row in batch["captures"]}
