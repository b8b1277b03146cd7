"""What is rendered, reconstructed and scored: one case per scene and rung, with variants of its reconstruction."""
import functools
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
DRIFT = pathlib.Path(__file__).resolve().parent / "drift.yaml"
FRONT_END = ("track", "ground", "layout", "detect", "segment", "associate")

CANDIDATES = ("propose", "register", "select")


class Variant:
    """Options that make a reconstruction differ, the variant from which it takes finished stages, what is scored.

    `tracked` is the trajectory before loops are closed and the graph is solved.
    """

    def __init__(self, options, kinds, origin=None, shared=()):
        self.options = options
        self.kinds = kinds
        self.origin = origin
        self.shared = shared


NO_LOOPS = ["--set", "loops.enabled=false"]
DRIFTING = ["--config", str(DRIFT)]
VARIANTS = {
    "": Variant([], ("trajectory", "tracked", "objects", "selection", "map", "detections")),
    "rgb": Variant(["--set", "propose.use_depth=false"], ("objects", "selection", "map"), "", FRONT_END),
    "no_loops": Variant(NO_LOOPS, ("trajectory", "objects"), "", FRONT_END + CANDIDATES),
    "drift": Variant(DRIFTING, ("trajectory", "tracked", "objects")),
    "drift_no_loops": Variant(DRIFTING + NO_LOOPS, ("trajectory", "objects"), "drift", FRONT_END + CANDIDATES),
}
# Scenes that come back to where they began after a long way.
LOOP_SCENES = ("long_loop",)


def call(command, log):
    """Runs a command; (ended well, seconds). What it said goes to `log`."""
    started = time.monotonic()
    with open(log, "ab") as out:
        out.write(("$ " + " ".join(command) + "\n").encode())
        out.flush()
        code = subprocess.run(command, stdout=out, stderr=out, check=False).returncode
        seconds = time.monotonic() - started
        out.write(f"# exit {code}, {seconds:.0f} s, load {os.getloadavg()[0]:.1f}\n".encode())
    if code != 0:
        print(f"{' '.join(command[1:3])} failed with exit {code}; see {log}", file=sys.stderr)
    return code == 0, seconds


def with_fewer_frames(text, most):
    """The scene with at most `most` frames over the same time and path."""
    frames = re.search(r"^frames:\s*(\d+)", text, re.MULTILINE)
    rate = re.search(r"^frames_per_s:\s*([\d.]+)", text, re.MULTILINE)
    if not (frames and rate) or int(frames.group(1)) <= most:
        return text
    text = text.replace(frames.group(0), f"frames: {most}")
    return text.replace(rate.group(0), f"frames_per_s: {float(rate.group(1)) * most / int(frames.group(1)):g}")


def with_half_images(text):
    """The scene with images of half the size, where its camera is written out."""
    def halved(match):
        return f"{match.group(1)}{float(match.group(2)) / 2:g}"

    camera = re.search(r"camera:\s*\{[^}]*\}", text)
    if not camera or "width" not in camera.group(0):
        return text
    short = re.sub(r"((?:width|height):\s*)(\d+)", lambda m: m.group(1) + str(int(m.group(2)) // 2), camera.group(0))
    short = re.sub(r"((?:fx|fy):\s*)([\d.]+)", halved, short)
    # Pixel (0, 0) is a pixel's centre: the middle of the first two is at 0.5.
    short = re.sub(r"((?:cx|cy):\s*)([\d.]+)", lambda m: f"{m.group(1)}{(float(m.group(2)) + 0.5) / 2 - 0.5:g}", short)
    return text.replace(camera.group(0), short)


def rungs_of(text):
    """Names of a scene's rungs (`rungs: {NAME: ...}`): "" is the scene as it stands, unless a rung changes nothing."""
    names, unchanged = [], False
    inside = False
    for line in text.splitlines():
        if re.match(r"rungs\s*:", line):
            inside = True
        elif inside and (match := re.match(r"  ([A-Za-z0-9_-]+)\s*:(.*)", line)):
            names.append(match.group(1))
            unchanged = unchanged or match.group(2).split("#")[0].strip() == "{}"
        elif inside and line and not line[0].isspace() and not line.startswith("#"):
            inside = False
    return names if unchanged else [""] + names


class Case:
    def __init__(self, scene, rung, work):
        self.scene = scene
        self.rung = rung
        self.name = scene.stem + ("_" + rung if rung else "")
        self.is_ladder = scene.stem == "ladder"
        self.work = work
        self.capture = work / "captures" / self.name
        self.log = work / "logs" / (self.name + ".log")

    def variants(self):
        names = ["", "rgb"]
        return names + ["no_loops", "drift", "drift_no_loops"] if self.name in LOOP_SCENES else names

    def workspace(self, variant=""):
        return self.work / "workspaces" / (self.name + ("." + variant if variant else ""))

    def result(self, kind, variant=""):
        return self.work / "results" / f"{self.name}{'.' + variant if variant else ''}.{kind}.json"

    def load(self, kind, variant=""):
        file = self.result(kind, variant)
        return json.loads(file.read_text()) if file.exists() else None


def commit():
    """The commit that a page of figures names; the word where the sources are in no repository."""
    asked = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "--short=8", "HEAD"], capture_output=True, text=True, check=False)
    return asked.stdout.strip() or "unknown"


@functools.cache
def program_hash(program):
    return hashlib.sha256(program.read_bytes()).hexdigest()


def render(case, args):
    """Renders the capture anew where its scene or the program changed; equal bytes keep finished stages valid."""
    text = case.scene.read_text()
    # Drift over a long way is what loops are for: thinned, it would be another capture.
    if args.quick or case.name not in LOOP_SCENES:
        text = with_fewer_frames(text, 60 if args.quick else args.max_frames)
    if args.quick:
        text = with_half_images(text)
    # Models given as files lie beside the scene: only a scene that is changed is written elsewhere.
    scene = case.scene
    if text != scene.read_text():
        scene = args.work / "scenes" / case.scene.name
        scene.parent.mkdir(exist_ok=True)
        scene.write_text(text)
    stamp = pathlib.Path(str(case.capture) + ".made_from")
    made_from = hashlib.sha256(f"{text}\n{case.rung}\n{program_hash(args.deepslam)}".encode()).hexdigest()
    if case.capture.exists() and stamp.exists() and stamp.read_text() == made_from:
        return True
    shutil.rmtree(case.capture, ignore_errors=True)
    command = [str(args.deepslam), "synth", str(scene), "-o", str(case.capture)]
    good, _ = call(command + (["--rung", case.rung] if case.rung else []), case.log)
    if good:
        stamp.write_text(made_from)
    return good


def reconstruct(case, name, args):
    variant = VARIANTS[name]
    workspace = case.workspace(name)
    if variant.origin is not None:
        # What the variant shares with its origin is taken over; the program checks by content what of it holds.
        origin = case.workspace(variant.origin)
        workspace.mkdir(exist_ok=True)
        for stage in variant.shared:
            shutil.rmtree(workspace / stage, ignore_errors=True)
            shutil.copytree(origin / stage, workspace / stage)
        shutil.copy(origin / "workspace.json", workspace)
    command = [str(args.deepslam), "run", str(case.capture), "-o", str(workspace), "--progress", "none",
               "--threads", str(args.threads), *args.run_options, *variant.options]
    return call(command + (["--until", "export"] if name else []), case.log)[0]


def score(case, name, args):
    workspace = case.workspace(name)
    made = (workspace / "export" / "manifest.json").stat().st_mtime
    pair = [str(workspace), str(case.capture)]
    for kind in VARIANTS[name].kinds:
        result = case.result(kind, name)
        if result.exists() and result.stat().st_mtime > made:
            continue
        result.unlink(missing_ok=True)
        paths = [kind, *pair]
        if kind == "tracked":
            paths = ["trajectory", str(workspace / "track" / "trajectory.tum"), str(case.capture / "groundtruth.txt")]
        call([str(args.deepslam), "eval", *paths, "--json", str(result)], case.log)


def make(case, args):
    """Renders, reconstructs and scores one case; True when all its variants were reconstructed."""
    for folder in ("captures", "workspaces", "results", "logs"):
        (args.work / folder).mkdir(parents=True, exist_ok=True)
    if not render(case, args):
        return False
    good = True
    for name in case.variants():
        print(f"{case.name} {name}".rstrip(), flush=True)
        if reconstruct(case, name, args):
            score(case, name, args)
        elif VARIANTS[name].origin is None and name == "":
            return False
        else:
            good = False
    return good
