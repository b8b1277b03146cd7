#!/usr/bin/env python3
"""Puts what scripts/bench.sh measured into one file for programs and one page.

    collect.py FOLDER      reads whole_run.json, whole_run.md and the results of Google Benchmark beside them; writes bench.json, bench.md
"""
import json
import pathlib
import sys

# Ours, theirs, what is compared.
PEERS = [("TrackDeepslam", "TrackOpen3d", "tracking, Open3D 0.16 (frame to frame, colour and depth)"),
         ("TrackDeepslam", "TrackOpencv", "tracking, OpenCV 4.6 (RgbdICPOdometry, frame to frame)"),
         ("FuseDeepslam", "FuseOpen3d", "fusion at 2 cm with extraction, Open3D 0.16 (ScalableTSDFVolume)")]


def medians(file):
    """name -> row: the medians where there are repetitions."""
    rows = {}
    for row in json.loads(file.read_text())["benchmarks"]:
        if row.get("error_occurred"):
            sys.exit(f"{file}: {row['name']}: {row['error_message']}")
        if row.get("run_type") == "aggregate" and row.get("aggregate_name") != "median":
            continue
        name = row.get("run_name", row["name"])
        if row.get("run_type") == "aggregate" or name not in rows:
            rows[name] = row
    return rows


def milliseconds(row):
    return row["real_time"] * {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}[row["time_unit"]]


def peers_table(rows):
    by_name = {name.split("/")[0]: row for name, row in rows.items()}
    lines = ["| what, beside whom | ours, ms per frame | theirs | theirs over ours | ATE ours, mm | theirs |", "| --- | --- | --- | --- | --- | --- |"]
    ratios = {}
    for ours, theirs, what in PEERS:
        own, other = by_name[ours], by_name[theirs]
        ratio = own["items_per_second"] / other["items_per_second"]
        ratios[f"{theirs}_over_{ours}"] = ratio
        errors = [f"{row['ate_mm']:.1f}" if "ate_mm" in row else "" for row in (own, other)]
        lines.append(f"| {what} | {1e3 / own['items_per_second']:.1f} | {1e3 / other['items_per_second']:.1f} | {ratio:.2f} | "
                     f"{errors[0]} | {errors[1]} |")
    return "\n".join(lines), ratios


def main():
    folder = pathlib.Path(sys.argv[1])
    result = {"whole_run": json.loads((folder / "whole_run.json").read_text())}
    page = [(folder / "whole_run.md").read_text()]
    for file in sorted(folder.glob("*.json")):
        if file.name in ("whole_run.json", "bench.json"):
            continue
        rows = medians(file)
        result[file.stem] = rows
        page.append(f"## `{file.stem}`\n")
        if file.stem == "peers":
            text, result["peer_ratios"] = peers_table(rows)
            page.append(text + "\n")
        page += ["| benchmark | ms | items per second |", "| --- | --- | --- |"]
        page += [f"| `{name}` | {milliseconds(row):.3f} | " + (f"{row['items_per_second']:.1f} |" if "items_per_second" in row else "|")
                 for name, row in rows.items()]
        page.append("")
    (folder / "bench.json").write_text(json.dumps(result, indent=1) + "\n")
    (folder / "bench.md").write_text("\n".join(page))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()
