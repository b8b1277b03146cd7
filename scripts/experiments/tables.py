"""Tables and plots of what was scored, as Markdown and SVG."""
import datetime
import html
import json

from cases import LOOP_SCENES, call, commit
from plots import bar_plot


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "|".join("---" for _ in header) + "|"]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def percent(value):
    return f"{100 * value:.1f}"


def interval(value):
    return "{mean:+.4f} [{low:+.4f}, {high:+.4f}]".format(**value)


def pooled(kind, cases, variant, name, args):
    """All captures scored as one set, by the program itself."""
    paths = []
    for case in cases:
        if case.load(kind, variant):
            paths += [str(case.workspace(variant)), str(case.capture)]
    if not paths:
        return None
    out = args.work / "results" / f"{name}.{kind}.json"
    if not call([str(args.deepslam), "eval", kind, *paths, "--json", str(out)], args.work / "logs" / "pooled.log")[0]:
        return None
    return json.loads(out.read_text())


def selection_table(selection):
    rows = [[row["row"], row["num_objects"], f'{row["iou"]:.4f}', interval(row["iou_minus_initial"]), f'{row["chamfer"]:.4f}',
             interval(row["chamfer_minus_initial"])] for row in selection["rows"] if row["num_objects"] > 0]
    return table(["choice", "objects", "IoU", "less initial, 95 %", "CD", "less initial, 95 %"], rows)


def selection_parts(cases, args):
    # Every object once: of the ladder the sensor as it is, of the others the scene as it stands.
    once = [case for case in cases if not case.rung or (case.is_ladder and case.rung == "sensor")]
    parts = []
    for variant, title in (("", "Proposals from colour and depth"), ("rgb", "Proposals from colour alone")):
        selection = pooled("selection", once, variant, "table1" + variant, args)
        if selection:
            parts += [f"### {title}", "", selection_table(selection), ""]
    if parts:
        parts = ["## Initial against improved (the paper's Table 1)", "",
                 "Captures: " + ", ".join(case.name for case in once if case.load("selection")) + ".", ""] + parts
    for case in cases:
        if case.rung == "held" and case.load("selection"):
            parts += [f"### {case.name}: the same room of products that the library holds", "",
                      selection_table(case.load("selection")), ""]
    return parts


def num_found(objects):
    return sum(row["num_found"] for row in objects["classes"])


def object_parts(cases):
    rows = []
    for case in cases:
        objects, tracked, final = case.load("objects"), case.load("tracked"), case.load("trajectory")
        if not (objects and tracked and final):
            continue
        s = objects["summary"]
        found = num_found(objects)
        shapes = [f'{s["iou"]:.3f}', f'{s["iou_as_placed"]:.3f}', f'{s["chamfer"]:.4f}', f'{s["in_place_iou"]:.3f}']
        mistaken = len(objects["mistaken"])
        rows.append([case.name, f'{found} / {s["num_true"]}', f'{found} / {s["num_mapped"]}', mistaken,
                     *(shapes if s["num_with_shape"] > 0 else ["-"] * 4), f'{s["num_placed"]} / {s["num_true"]}',
                     f'{100 * tracked["ate_m"]["rmse"]:.2f}', f'{100 * final["ate_m"]["rmse"]:.2f}',
                     f'{final["num_scored"]} / {final["num_frames"]}'])
    return ["## Objects and trajectories", "",
            "`mistaken`: true objects that stand in the map under another class.", "",
            table(["capture", "recall", "precision", "mistaken", "IoU", "IoU as placed", "CD", "metric IoU",
                   "placed 20/20/20", "ATE cm tracked", "ATE cm optimized", "frames scored"], rows), ""] if rows else []


def detection_parts(cases):
    rows = []
    classes = {}
    for case in cases:
        result = case.load("detections")
        if not result:
            continue
        s = result["summary"]
        seen = max(1, s["num_seen"])
        rows.append([case.name, s["num_frames"], s["num_seen"], percent(s["num_found_by_network"] / seen), percent(s["recall"]),
                     percent(s["num_found_any_class"] / seen), percent(s["precision"]),
                     f'{s["num_objects_found"]} / {s["num_objects"]}'])
        if case.is_ladder and case.rung != "sensor":
            continue
        for row in result["classes"]:
            total = classes.setdefault(row["class"], [0, 0, 0, 0, 0])
            for n, key in enumerate(("num_seen", "num_found_by_network", "num_found", "num_found_any_class", "num_detected")):
                total[n] += row[key]
    if not rows:
        return []
    class_rows = [[name, t[0], *([percent(t[n] / t[0]) for n in (1, 2, 3)] if t[0] else ["-"] * 3),
                   percent(t[2] / t[4]) if t[4] else "-"] for name, t in sorted(classes.items())]
    header = ["boxes to find", "by the network %", "and by depth clusters %", "whatever the class %", "precision %"]
    return ["## The detector on rendered frames", "",
            "Boxes of stage `detect` in its keyframes, IoU 0.5 with the box of the visible part.", "",
            table(["capture", "frames", *header, "objects found at least once"], rows), "",
            table(["class, all captures but degraded ones", *header], class_rows), ""]


def map_parts(cases, plot):
    rows = []
    for case in cases:
        result = case.load("map")
        if not result:
            continue
        ours, tsdf, size = result["object_map"], result["tsdf"], result["bytes"]
        rows.append([case.name, *(percent(side[key]) for side in (ours, tsdf) for key in ("completeness", "accuracy", "f_score")),
                     size["map_json"], size["scene_glb"], size.get("fused_cloud", "-"), f'{size.get("fused_cloud_per_map", 0):.0f}'])
    if not rows:
        return []
    names = [row[0] for row in rows]
    return ["## Object map beside TSDF fusion of the same frames with the same poses, at 5 cm", "",
            table(["capture", "map complete %", "accurate %", "F %", "TSDF complete %", "accurate %", "F %", "map.json bytes",
                   "GLB bytes", "fused cloud bytes", "cloud / map"], rows), "",
            *plot("bytes.svg", "Size, logarithmic", names, {"map.json": [row[7] for row in rows],
                                                            "fused cloud": [row[9] if row[9] != "-" else None for row in rows]}, "bytes", True)]


def ladder_parts(cases, plot):
    ladder = [case for case in cases if case.is_ladder and case.load("map")]
    if not ladder:
        return []
    names = [case.rung for case in ladder]
    measures = {"completeness": "Completeness", "accuracy": "Accuracy", "f_score": "F-score"}
    maps = {"map, colour and depth": ("", "object_map"), "map, colour alone": ("rgb", "object_map"), "TSDF": ("", "tsdf")}
    rows = []
    for case in ladder:
        row = [case.rung]
        for variant in ("", "rgb"):
            objects, selection = case.load("objects", variant), case.load("selection", variant)
            chosen = {r["row"]: r for r in selection["rows"] if r["num_objects"] > 0} if selection else {}
            row.append(f'{num_found(objects)} / {objects["summary"]["num_true"]} / {objects["summary"]["num_mapped"]}' if objects else "-")
            row += [f'{chosen[key]["iou"]:.3f} / {chosen[key]["chamfer"]:.4f}' if key in chosen else "-" for key in ("initial", "selected")]
        for variant, side in maps.values():
            result = case.load("map", variant)
            row.append(" / ".join(percent(result[side][key]) for key in measures) if result else "-")
        rows.append(row)
    parts = ["## The degradation ladder: proposals from colour alone beside colour and depth, and TSDF", "",
             "found / true / mapped objects; IoU / CD of the shapes found; complete / accurate / F at 5 cm, %.", "",
             table(["rung", "colour and depth: objects", "initial", "selected", "colour alone: objects", "initial", "selected",
                    *maps], rows), ""]
    for key, title in measures.items():
        series = {name: [100 * result[side][key] if (result := case.load("map", variant)) else None for case in ladder]
                  for name, (variant, side) in maps.items()}
        parts += plot(f"ladder_{key}.svg", f"{title} at 5 cm over the objects", names, series, "%")
    series = {}
    for variant, title in (("", "colour and depth"), ("rgb", "colour alone")):
        for choice in ("initial", "selected"):
            series[f"{title}: {choice}"] = [
                next((r["iou"] for r in (case.load("selection", variant) or {"rows": []})["rows"]
                      if r["row"] == choice and r["num_objects"] > 0), None) for case in ladder]
    return parts + plot("ladder_iou.svg", "IoU of the objects found", names, series, "1")


def loop_parts(cases):
    rows = []
    for case in cases:
        if case.name not in LOOP_SCENES:
            continue
        for variant, title in (("", "default tracking"), ("drift", "frame-to-frame tracking")):
            without = "drift_no_loops" if variant else "no_loops"
            tracked = case.load("tracked", variant)
            for name, loops in ((without, "off"), (variant, "on")):
                final, objects = case.load("trajectory", name), case.load("objects", name)
                if not (tracked and final and objects):
                    continue
                s = objects["summary"]
                found = num_found(objects)
                file = case.workspace(name) / "loops" / "loops.json"
                closed = json.loads(file.read_text()) if file.exists() else {"constellations": [], "merges": []}
                rows.append([case.name, title, loops, f'{100 * tracked["ate_m"]["rmse"]:.1f}', f'{100 * final["ate_m"]["rmse"]:.1f}',
                             sum(c["accepted"] for c in closed["constellations"]), len(closed["merges"]), s["num_mapped"], f'{found} / {s["num_true"]}',
                             s["num_mapped"] - found, f'{s["num_placed"]} / {s["num_true"]}'])
    if not rows:
        return []
    return ["## Loop closure", "",
            "`left over`: mapped objects that are no true one of their class, duplicates among them.", "",
            table(["capture", "tracking", "loops", "ATE cm tracked", "ATE cm optimized", "constellations", "merged", "mapped", "found",
                   "left over", "placed 20/20/20"], rows), ""]


def write_results(cases, args, command):
    folder = args.docs
    folder.mkdir(parents=True, exist_ok=True)

    def plot(file, title, groups, series, unit, log_scale=False):
        svg = bar_plot(title, groups, series, unit, log_scale)
        if not svg:
            return []
        (folder / file).write_text(f"<!-- {html.escape(command).replace('--', '- -')} -->\n" + svg)
        return [f"![{title}]({file})", ""]

    parts = ["# Results of scripts/experiments/run.py", "",
             f"Tables and plots made by `{command}`, commit {commit()}, {datetime.date.today()}; protocols in ../evaluation.md.", ""]
    parts += selection_parts(cases, args)
    parts += ladder_parts(cases, plot)
    parts += object_parts(cases)
    parts += map_parts(cases, plot)
    parts += loop_parts(cases)
    parts += detection_parts(cases)
    failed = [case.name for case in cases if not case.load("objects")]
    if failed:
        parts += ["Not run yet, or failed (see the logs): " + ", ".join(failed), ""]
    (folder / "results.md").write_text("\n".join(parts))
    print(folder / "results.md")
