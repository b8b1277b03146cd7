#!/usr/bin/env python3
"""The project's experiments on rendered captures, with one command:

    scripts/experiments/run.py --deepslam build/release/tools/deepslam --work out/experiments [--quick] [--scene F]...

Renders the scenes (all of configs/scenes unless --scene names some), reconstructs them, scores the results and writes
docs/evaluation/results.md and docs/evaluation/*.svg, each with the command that made it. What exists in --work is used
again. --quick takes at most 60 frames a scene and halves images whose camera is written out. Every rung of a scene
is a capture of its own. Needs nothing beyond Python 3.
"""
import argparse
import html
import json
import os
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
COLOURS = ["#1f6fb4", "#d1605e", "#5a9e4b", "#8c6bb1"]


def call(command, log):
    """Runs a command; True when it ended well. What it said goes to `log`."""
    started = time.monotonic()
    with open(log, "ab") as out:
        out.write(("$ " + " ".join(command) + "\n").encode())
        out.flush()
        code = subprocess.run(command, stdout=out, stderr=out, check=False).returncode
        out.write(f"# exit {code}, {time.monotonic() - started:.0f} s\n".encode())
    if code != 0:
        print(f"{command[1]} failed with exit {code}; see {log}", file=sys.stderr)
    return code == 0


def quick_scene(text):
    """The scene with at most 60 frames over the same path; half the size where the camera is written out."""
    def halved(match):
        return f"{match.group(1)}{float(match.group(2)) / 2:g}"

    camera = re.search(r"camera:\s*\{[^}]*\}", text)
    if camera and "width" in camera.group(0):
        short = re.sub(r"((?:width|height):\s*)(\d+)", lambda m: m.group(1) + str(int(m.group(2)) // 2), camera.group(0))
        short = re.sub(r"((?:fx|fy):\s*)([\d.]+)", halved, short)
        # Pixel (0, 0) is a pixel's centre: the middle of the first two is at 0.5.
        short = re.sub(r"((?:cx|cy):\s*)([\d.]+)", lambda m: f"{m.group(1)}{(float(m.group(2)) + 0.5) / 2 - 0.5:g}", short)
        text = text.replace(camera.group(0), short)
    frames = re.search(r"^frames:\s*(\d+)", text, re.MULTILINE)
    rate = re.search(r"^frames_per_s:\s*([\d.]+)", text, re.MULTILINE)
    if frames and rate and int(frames.group(1)) > 60:
        text = text.replace(frames.group(0), "frames: 60")
        text = text.replace(rate.group(0), f"frames_per_s: {float(rate.group(1)) * 60 / int(frames.group(1)):g}")
    return text


def rungs_of(scene):
    """Names of a scene's rungs (`rungs: {NAME: ...}`), [""] for a scene without."""
    names = []
    inside = False
    for line in scene.read_text().splitlines():
        if re.match(r"rungs\s*:", line):
            inside = True
        elif inside and (match := re.match(r"  ([A-Za-z0-9_-]+)\s*:", line)):
            names.append(match.group(1))
        elif inside and line and not line[0].isspace() and not line.startswith("#"):
            inside = False
    return names or [""]


class Case:
    def __init__(self, scene, rung, work):
        self.scene = scene
        self.rung = rung
        self.name = scene.stem + ("_" + rung if rung else "")
        self.capture = work / "captures" / self.name
        self.workspace = work / "workspaces" / self.name
        self.results = work / "results"
        self.log = work / "logs" / (self.name + ".log")

    def load(self, kind):
        file = self.results / f"{self.name}.{kind}.json"
        return json.loads(file.read_text()) if file.exists() else None


def make(case, args):
    """Renders, reconstructs and scores one case."""
    for folder in (case.capture.parent, case.workspace.parent, case.results, case.log.parent):
        folder.mkdir(parents=True, exist_ok=True)
    program = str(args.deepslam)
    scene = case.scene
    if args.quick:
        scene = args.work / "scenes" / case.scene.name
        scene.parent.mkdir(exist_ok=True)
        scene.write_text(quick_scene(case.scene.read_text()))
    if not (case.capture / "capture.yaml").exists():
        command = [program, "synth", str(scene), "-o", str(case.capture)]
        if case.rung:
            command += ["--rung", case.rung]
        if not call(command, case.log):
            return False
    if not call([program, "run", str(case.capture), "-o", str(case.workspace), "--progress", "none"], case.log):
        return False
    pair = [str(case.workspace), str(case.capture)]
    # `tracked`: before loops are closed and the graph is solved.
    kinds = {"trajectory": pair, "objects": pair, "selection": pair, "map": pair,
             "tracked": [str(case.workspace / "track" / "trajectory.tum"), str(case.capture / "groundtruth.txt")]}
    made = case.workspace / "export" / "manifest.json"
    for kind, paths in kinds.items():
        result = case.results / f"{case.name}.{kind}.json"
        if result.exists() and result.stat().st_mtime > made.stat().st_mtime:
            continue
        result.unlink(missing_ok=True)
        call([program, "eval", "trajectory" if kind == "tracked" else kind, *paths, "--json", str(result)], case.log)
    return True


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "|".join("---" for _ in header) + "|"]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def bar_plot(title, groups, series, unit, log_scale=False):
    """Grouped bars as an SVG text. `series`: {name: [value or None per group]}."""
    import math
    width, height, left, top, bottom = 760, 340, 60, 40, 90
    values = [v for row in series.values() for v in row if v is not None and v > 0]
    if not values:
        return None
    high = max(values)
    low = min(values) / 2 if log_scale else 0

    def scale(value):
        if log_scale:
            share = math.log(value / low) / math.log(high / low)
        else:
            share = value / high
        return share * (height - top - bottom)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{left}" y="22" font-size="14">{html.escape(title)} [{html.escape(unit)}]</text>']
    step = (width - left - 20) / len(groups)
    bar = step * 0.8 / len(series)
    for g, group in enumerate(groups):
        x0 = left + g * step + 0.1 * step
        for s, (name, row) in enumerate(series.items()):
            value = row[g]
            if value is None or value <= 0:
                continue
            size = scale(value)
            y = height - bottom - size
            out.append(f'<rect x="{x0 + s * bar:.1f}" y="{y:.1f}" width="{bar * 0.95:.1f}" height="{size:.1f}" fill="{COLOURS[s % 4]}"/>')
            out.append(f'<text x="{x0 + (s + 0.5) * bar:.1f}" y="{y - 3:.1f}" text-anchor="middle" font-size="9">{value:.3g}</text>')
        x = x0 + 0.4 * step
        y = height - bottom + 14
        out.append(f'<text x="{x:.1f}" y="{y}" text-anchor="end" transform="rotate(-30 {x:.1f} {y})" font-size="10">{html.escape(group)}</text>')
    for s, name in enumerate(series):
        out.append(f'<rect x="{left + 150 * s}" y="{height - 16}" width="10" height="10" fill="{COLOURS[s % 4]}"/>')
        out.append(f'<text x="{left + 150 * s + 14}" y="{height - 7}">{html.escape(name)}</text>')
    out.append(f'<line x1="{left}" y1="{height - bottom}" x2="{width - 20}" y2="{height - bottom}" stroke="#444"/>')
    return "\n".join(out + ["</svg>", ""])


def percent(value):
    return f"{100 * value:.1f}"


def pooled_selection(cases, args):
    """Table 1: all scenes scored as one set, by the program itself."""
    paths = []
    for case in cases:
        if case.load("selection"):
            paths += [str(case.workspace), str(case.capture)]
    if not paths:
        return None
    out = args.work / "results" / "all.selection.json"
    if not call([str(args.deepslam), "eval", "selection", *paths, "--json", str(out)], args.work / "logs" / "all.log"):
        return None
    return json.loads(out.read_text())


def write_tables(cases, args, command):
    parts = ["# Results of scripts/experiments/run.py", "", f"Made by `{command}`; protocols in ../evaluation.md.", ""]
    selection = pooled_selection(cases, args)
    if selection:
        rows = [[row["row"], row["num_objects"], f'{row["iou"]:.4f}',
                 "{mean:+.4f} [{low:+.4f}, {high:+.4f}]".format(**row["iou_minus_initial"]), f'{row["chamfer"]:.4f}',
                 "{mean:+.4f} [{low:+.4f}, {high:+.4f}]".format(**row["chamfer_minus_initial"])]
                for row in selection["rows"] if row["num_objects"] > 0]
        parts += ["## Initial against improved (the paper's Table 1)", "",
                  table(["choice", "objects", "IoU", "less initial, 95 %", "CD", "less initial, 95 %"], rows), ""]
    rows = []
    for case in cases:
        objects, tracked, final = case.load("objects"), case.load("tracked"), case.load("trajectory")
        if not (objects and tracked and final):
            continue
        s = objects["summary"]
        num_found = sum(row["num_found"] for row in objects["classes"])
        shapes = [f'{s["iou"]:.3f}', f'{s["iou_as_placed"]:.3f}', f'{s["chamfer"]:.4f}', f'{s["in_place_iou"]:.3f}']
        rows.append([case.name, f'{num_found} / {s["num_true"]}', f'{num_found} / {s["num_mapped"]}',
                     *(shapes if s["num_with_shape"] > 0 else ["-"] * 4), f'{s["num_placed"]} / {s["num_true"]}',
                     f'{100 * tracked["ate_m"]["rmse"]:.2f}', f'{100 * final["ate_m"]["rmse"]:.2f}',
                     f'{final["num_scored"]} / {final["num_frames"]}'])
    parts += ["## Objects and trajectories", "",
              table(["capture", "recall", "precision", "IoU", "IoU as placed", "CD", "metric IoU", "placed 20/20/20",
                     "ATE cm tracked", "ATE cm optimized", "frames scored"], rows), ""]
    rows, names = [], []
    f_map, f_tsdf, size_map, size_cloud = [], [], [], []
    for case in cases:
        result = case.load("map")
        if not result:
            continue
        ours, tsdf, size = result["object_map"], result["tsdf"], result["bytes"]
        names.append(case.name)
        f_map.append(100 * ours["f_score"])
        f_tsdf.append(100 * tsdf["f_score"])
        size_map.append(size["map_json"])
        size_cloud.append(size.get("fused_cloud"))
        rows.append([case.name, percent(ours["completeness"]), percent(ours["accuracy"]), percent(ours["f_score"]),
                     percent(tsdf["completeness"]), percent(tsdf["accuracy"]), percent(tsdf["f_score"]),
                     size["map_json"], size["scene_glb"], size.get("fused_cloud", "-"), f'{size.get("fused_cloud_per_map", 0):.0f}'])
    parts += ["## Object map beside TSDF fusion of the same frames with the same poses, at 5 cm", "",
              table(["capture", "map complete %", "accurate %", "F %", "TSDF complete %", "accurate %", "F %", "map.json bytes",
                     "GLB bytes", "fused cloud bytes", "cloud / map"], rows), ""]
    folder = ROOT / "docs" / "evaluation" if not args.docs else args.docs
    folder.mkdir(parents=True, exist_ok=True)
    for file, svg in (("f_score.svg", bar_plot("F-score at 5 cm over the objects", names, {"object map": f_map, "TSDF": f_tsdf}, "%") if names else None),
                      ("bytes.svg", bar_plot("Size, logarithmic", names, {"map.json": size_map, "fused cloud": size_cloud}, "bytes", True) if names else None)):
        if svg:
            (folder / file).write_text(f"<!-- {html.escape(command).replace('--', '- -')} -->\n" + svg)
            parts += [f"![{file}]({file})", ""]
    failed = [case.name for case in cases if not case.load("objects")]
    if failed:
        parts += ["Not scored (see the logs): " + ", ".join(failed), ""]
    (folder / "results.md").write_text("\n".join(parts))
    print(folder / "results.md")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/experiments")
    parser.add_argument("--docs", type=pathlib.Path, help="where tables and plots go (default: docs/evaluation)")
    parser.add_argument("--scene", type=pathlib.Path, action="append", help="a scene file; may be repeated")
    parser.add_argument("--rung", action="append", help="of scenes with rungs only this one; may be repeated")
    parser.add_argument("--quick", action="store_true", help="half the image size, at most 60 frames")
    args = parser.parse_args()
    args.deepslam = args.deepslam.absolute()
    args.work = args.work.absolute()
    if not os.access(args.deepslam, os.X_OK):
        sys.exit(f"{args.deepslam}: no such program; build it (scripts/build.sh) or name it with --deepslam")
    scenes = [scene.absolute() for scene in args.scene or []] or sorted((ROOT / "configs" / "scenes").glob("*.yaml"))
    args.work.mkdir(parents=True, exist_ok=True)
    cases = [Case(scene, rung, args.work) for scene in scenes for rung in rungs_of(scene)
             if not args.rung or not rung or rung in args.rung]
    made = [case for case in cases if make(case, args)]
    command = "scripts/experiments/run.py" + "".join(
        f" --scene {scene}" for scene in args.scene or []) + "".join(f" --rung {rung}" for rung in args.rung or []) + (" --quick" if args.quick else "")
    write_tables(cases, args, command)
    return 0 if len(made) == len(cases) else 1


if __name__ == "__main__":
    sys.exit(main())
