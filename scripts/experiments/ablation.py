#!/usr/bin/env python3
"""What each mechanism is worth: every capture with the program's defaults, then with one mechanism off at a time.

    scripts/experiments/ablation.py NAME=CAPTURE... [--work out/ablation] [--only MECHANISM]... [--page FILE] [-- RUN OPTIONS]

Captures with a folder `truth` count as rendered, others as real; each is scored by what it has: the path's error
(groundtruth.txt), boxes (objects.json), shapes (meshes of the truth, else depth of frames that no object's view comes
from). Prints a table, and writes it to --page as Markdown: per mechanism and capture what changes when it is off, beyond
1 mm and a tenth of the path's error, one object, and 0.01 of agreement or IoU; processor time of all captures, as a
share of the time with it. What is finished in --work is used again. Needs nothing beyond Python 3.
"""
import argparse
import hashlib
import json
import pathlib
import resource
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

# What is switched off, and by which options.
MECHANISMS = {
    "smoothing of depth by its noise": {"track.smooth_depth": "false"},
    "intensity in the alignment": {"track.photometric": "false"},
    "alignment to keyframes": {"track.reference": "previous"},
    "motion prediction": {"track.motion_prediction": "false"},
    "search over rotations": {"track.rotation_search": "false"},
    "covisible keyframes": {"track.covisible.enabled": "false"},
    "sub-trajectories joined by appearance": {"track.join.enabled": "false"},
    "layout aligned to its walls": {"layout.align": "false"},
    "boxes from clusters of depth": {"detect.clusters.enabled": "false"},
    "detection on keyframes alone": {"detect.frames": "all"},
    "of them on those of new surface": {"detect.frames": "keyframes"},
    "proposals from depth beside colour": {"propose.use_depth": "false"},
    "library of models": {"propose.retrieval": "false"},
    "fused surfaces": {"propose.fused": "false"},
    "shape networks": {"propose.network": "false"},
    "mean of the views' latents": {"propose.networks.mean_latent": "false"},
    "proportions fitted to the depth": {"propose.networks.fit_proportions": "false"},
    "selection over all views": {"select.mode": "greedy"},
    "completion by measured depth": {"select.refine.complete": "false"},
    "level faces followed": {"select.refine.follow_level_face": "false"},
    "loops": {"loops.enabled": "false"},
    "loops by constellations of objects": {"loops.constellations": "false"},
    "loops by appearance": {"loops.appearance.enabled": "false"},
    "overlapping objects merged": {"loops.merge_overlapping": "false"},
    "robust losses": {"optimize.object_loss": "none", "optimize.loop_loss": "none", "optimize.ground_loss": "none"},
    "edges of objects": {"optimize.use_objects": "false"},
    "frames moved between keyframes": {"optimize.interpolate_frames": "false"},
    "colours of an object's own segment": {"mesh.colour.segment_only": "false"},
}
ATE_FLOOR_CM = 0.1
ATE_SHARE = 0.1
SCORE_FLOOR = 0.01


class Capture:
    def __init__(self, text):
        self.name, _, folder = text.partition("=")
        self.folder = pathlib.Path(folder).absolute()
        if not self.name or not self.folder.is_dir():
            sys.exit(f"{text}: expected NAME=FOLDER of a capture")
        self.rendered = (self.folder / "truth").is_dir()
        self.has_path = (self.folder / "groundtruth.txt").is_file()
        self.has_objects = any((self.folder / place).is_file() for place in ("objects.json", "truth/objects.json"))


class Program:
    def __init__(self, args):
        self.args = args
        self.hash = hashlib.sha256(args.deepslam.read_bytes()).hexdigest()

    def call(self, log, *command):
        """Processor seconds; None where the command fails."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        with open(log, "ab") as out:
            done = subprocess.run([str(self.args.deepslam), *map(str, command)], stdout=out, stderr=out, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return None if done.returncode else after.ru_utime - before.ru_utime

    def eval(self, log, kind, workspace, capture, *more):
        file = workspace.parent / f"{workspace.name}.{kind}.json"
        ended = self.call(log, "eval", kind, workspace, capture.folder, *more, "--json", file)
        return None if ended is None else json.loads(file.read_text())

    def scores(self, log, workspace, capture):
        scores = {}
        if capture.has_path and (found := self.eval(log, "trajectory", workspace, capture)):
            scores["ATE cm"] = 100 * found["ate_m"]["rmse"]
            scores["frames"] = found["num_scored"]
        if capture.has_objects and (found := self.eval(log, "objects", workspace, capture)):
            boxes = found["boxes"]["scores"][0]
            scores["found"], scores["right class"] = boxes["num_found"], boxes["num_right_class"]
            scores["mapped"] = boxes["num_mapped"]
            if found["summary"]["num_with_shape"]:
                scores["IoU"] = found["summary"]["in_place_iou"]
        elif (workspace / "select/objects.json").is_file():  # else the run options end before
            scores["mapped"] = len(json.loads((workspace / "select/objects.json").read_text())["objects"])
        if not capture.rendered and (found := self.eval(log, "selection", workspace, capture, "--held-out")):
            scores["held-out"] = found["selected"]["mean"]
        return scores

    def run(self, capture, name, options):
        """The scores of one run, or those that are kept of it; None where it fails."""
        folder = self.args.work / capture.name
        folder.mkdir(parents=True, exist_ok=True)
        key = hashlib.sha256(json.dumps([self.hash, str(capture.folder), options, self.args.run_options]).encode()).hexdigest()
        kept = folder / f"{name.replace(' ', '_')}.json"
        if kept.is_file() and (found := json.loads(kept.read_text()))["key"] == key:
            return found
        workspace = folder / name.replace(" ", "_")
        shutil.rmtree(workspace, ignore_errors=True)
        if name != "all":  # stages that the option does not touch are taken from there; files are never written in place
            subprocess.run(["cp", "-al", folder / "all", workspace], check=True)
        settings = [word for option, value in options.items() for word in ("--set", f"{option}={value}")]
        log = folder / f"{name.replace(' ', '_')}.log"
        spent = self.call(log, "run", capture.folder, "-o", workspace, "--threads", self.args.threads, "--progress", "none",
                          *self.args.run_options, *settings)
        if spent is None:
            print(f"{capture.name} without {name} fails; see {log}", file=sys.stderr)
            return None
        found = {"key": key, "seconds": seconds_of(workspace), "scores": self.scores(log, workspace, capture)}
        kept.write_text(json.dumps(found))
        if name != "all":
            shutil.rmtree(workspace)
        return found


def seconds_of(workspace):
    """Processor time of all stages, whichever run made them."""
    return sum(json.loads(file.read_text()).get("cpu_s", 0) for file in workspace.glob("*/timing.json"))


def changes(with_it, without):
    """What is worse or better without, in words; empty where nothing is beyond the noise."""
    told = []
    for name in with_it:
        if name not in without:
            told.append(f"no {name}")
            continue
        before, after = with_it[name], without[name]
        if name == "ATE cm":
            differs = abs(after - before) > max(ATE_FLOOR_CM, ATE_SHARE * before)
        elif isinstance(before, int):
            differs = before != after
        else:
            differs = abs(after - before) > SCORE_FLOOR
        if differs:
            form = "{}" if isinstance(before, int) else "{:.2f}"
            quantity = name.removesuffix(" cm")  # errors of the path go without their name
            told.append(f"{quantity + ' ' if quantity != 'ATE' else ''}{form.format(before)} → {form.format(after)}"
                        f"{' cm' if name.endswith(' cm') else ''}")
    return ", ".join(told)


def table(captures, results, names):
    """Markdown: captures as they are, then a row for each mechanism."""
    lines = ["| capture | " + " | ".join(capture.name for capture in captures) + " |", "|---" * (len(captures) + 1) + "|"]
    every = [name for name in ("ATE cm", "frames", "found", "right class", "mapped", "IoU", "held-out")
             if any(name in results[capture.name, "all"]["scores"] for capture in captures)]
    for name in every:
        cells = []
        for capture in captures:
            value = results[capture.name, "all"]["scores"].get(name)
            cells.append("" if value is None else str(value) if isinstance(value, int) else f"{value:.2f}")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    lines += ["", "| without | " + " | ".join(capture.name for capture in captures) + " | time |", "|---" * (len(captures) + 2) + "|"]
    for mechanism in names:
        cells, spent, base = [], 0.0, 0.0
        for capture in captures:
            found, whole = results.get((capture.name, mechanism)), results[capture.name, "all"]
            if found is None:
                cells.append("fails")
                continue
            spent += found["seconds"]
            base += whole["seconds"]
            cells.append(changes(whole["scores"], found["scores"]))
        lines.append(f"| {mechanism} | " + " | ".join(cells) + f" | {spent / base:.2f} |" if base else " | |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("captures", nargs="+", metavar="NAME=CAPTURE")
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/ablation")
    parser.add_argument("--only", action="append", choices=sorted(MECHANISMS), help="a mechanism; may be repeated")
    parser.add_argument("--page", type=pathlib.Path, help="where the table goes as Markdown")
    parser.add_argument("--threads", type=int, default=2)
    words = sys.argv[1:]
    cut = words.index("--") if "--" in words else len(words)
    args = parser.parse_args(words[:cut])
    args.run_options = words[cut + 1:]
    args.deepslam, args.work = args.deepslam.absolute(), args.work.absolute()
    if not args.deepslam.is_file():
        sys.exit(f"{args.deepslam}: no such program; build it (scripts/build.sh) or name it with --deepslam")
    captures = [Capture(text) for text in args.captures]
    captures.sort(key=lambda capture: capture.rendered)
    program = Program(args)
    names = [name for name in MECHANISMS if not args.only or name in args.only]
    results = {}
    for capture in captures:
        results[capture.name, "all"] = program.run(capture, "all", {})
        if results[capture.name, "all"] is None:
            sys.exit(f"{capture.name} fails as it is")
        for name in names:
            results[capture.name, name] = program.run(capture, name, MECHANISMS[name])
            print(f"{capture.name}: {name}", file=sys.stderr)
    text = table(captures, results, names)
    print(text)
    if args.page:
        args.page.write_text(text)


if __name__ == "__main__":
    main()
