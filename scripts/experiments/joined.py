#!/usr/bin/env python3
"""Two pieces in one capture: what is tied together that should not be, and is what could be tied?

    scripts/experiments/joined.py [--seeds 0-49] [--work out/loops] [--kinds other,leap] [-- RUN OPTIONS]

Made of the captures of loops.py (same seeds, same --work; rendered where they are missing), by links. `other`: 60 frames
of one room, then 60 of the next; nothing may tie them. `leap`: 60 frames of a room, then the last 60 of its second lap;
ties have to be right within 10 cm and 5 deg. Each from three places of the way. Stage `track` alone is run; a tie is an
edge of its graph across the join that was measured. With `-- --until loops` (half a minute a capture) objects are counted
too: those with views of either piece where nothing ties the pieces together, tracking or loops, are of two rooms. One JSON a
capture goes to stderr, the table to stdout. Needs nothing beyond Python 3.
"""
import itertools
import os
import shutil
import sys

import loops
import seeded

KINDS = ("other", "leap")
LENGTH = 60
OFFSETS = (0, 25, 50)  # of the first piece; the second begins BEHIND frames later, or ends with the capture
BEHIND = 30
INTERVAL_S = 1 / 15


def stamped_lines(path):
    return [line.split(maxsplit=1) for line in path.read_text().splitlines() if line and not line.startswith("#")]


def joined(pieces, folder):
    """One capture of the pieces [(capture, frames)]; times go on evenly."""
    if (folder / "groundtruth.txt").exists():
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    lists = {"rgb": [], "depth": [], "groundtruth": []}
    at = 0
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True)
    for capture, frames in pieces:
        rows = {name: stamped_lines(capture / f"{name}.txt") for name in lists}
        for frame in frames:
            for name in ("rgb", "depth"):
                source = capture / rows[name][frame][1].strip()
                target = f"{name}/{at:06d}{source.suffix}"
                os.link(source, folder / target)
                lists[name].append(f"{at * INTERVAL_S:.6f} {target}")
            lists["groundtruth"].append(f"{at * INTERVAL_S:.6f} {rows['groundtruth'][frame][1]}")
            at += 1
    shutil.copy(pieces[0][0] / "capture.yaml", folder)
    for name in ("rgb", "depth", "groundtruth"):
        (folder / f"{name}.txt").write_text("\n".join(lists[name]) + "\n")
    return folder


def edges(g2o):
    """(i, j, i_from_j) by frames."""
    for line in g2o.read_text().splitlines():
        words = line.split()
        if words and words[0] == "EDGE_SE3:QUAT":
            values = [float(word) for word in words[3:10]]
            yield int(words[1]), int(words[2]), loops.pose(values[3:], values[:3])


def ties(capture, workspace, join):
    """(i, j, (m, deg) off the truth) of what is measured across the join; and the frames that are lost."""
    table = loops.read_json(workspace / "track/frames.json")
    composed = {tuple(pair) for pair in table["composed_edges"]}
    truth = [row[1] for row in loops.read_tum(capture / "groundtruth.txt")]
    found = []
    for i, j, i_from_j in edges(workspace / "track/odometry.g2o"):
        if (i, j) not in composed and (i < join) != (j < join):
            found.append((i, j, loops.off(i_from_j, loops.times(loops.inverse(truth[i]), truth[j]))))
    return found, [row["frame"] for row in table["frames"] if row["status"] == "lost"]


def mixed(workspace, join, tied):
    """Objects seen in both pieces though nothing ties these together; None where no objects were looked for."""
    objects, loops_found = workspace / "loops/objects.json", workspace / "loops/loops.json"
    if not objects.exists():
        return None
    edges_found = [(edge["i"], edge["j"]) for edge in loops.read_json(loops_found)["edges"]]
    if tied or any((i < join) != (j < join) for i, j in edges_found):
        return 0
    views = [[view["frame"] < join for view in row["views"]] for row in loops.read_json(objects)["objects"]]
    return sum(len(set(sides)) > 1 for sides in views)


def is_wrong(tie, kind):
    return kind == "other" or tie[2][0] > loops.WRONG_M or tie[2][1] > loops.WRONG_DEG


def one(args, seed, kind, offset):
    """The figures of one capture; None where its run failed (its log says why)."""
    name = f"{seed:03d}.{kind}{offset}"
    here = args.work / "captures" / f"{seed:03d}"
    following = args.seeds[(args.seeds.index(seed) + 1) % len(args.seeds)]
    there = here if kind == "leap" else args.work / "captures" / f"{following:03d}"
    begin = loops.FRAMES - LENGTH if kind == "leap" else offset + BEHIND
    pieces = [(here, range(offset, offset + LENGTH)), (there, range(begin, begin + LENGTH))]
    capture = joined(pieces, args.work / "joined" / name)
    workspace = args.work / "workspaces" / name
    if not seeded.call(args, name, "run", capture, "-o", workspace, "--progress", "none", "--threads", args.threads,
                       *([] if "--until" in args.run_options else ["--until", "track"]), *args.run_options):
        return None
    found, lost = ties(capture, workspace, LENGTH)
    wrong = [tie for tie in found if is_wrong(tie, kind)]
    return {"name": name, "kind": kind, "ties": len(found), "wrong": wrong, "lost": lost,
            "mixed": mixed(workspace, LENGTH, bool(found))}


def table(rows, kinds):
    lines = ["| pieces | captures | tied | wrongly | no frame lost | with objects of two rooms |", "|---|---|---|---|---|---|"]
    for kind in kinds:
        group = [row for row in rows if row["kind"] == kind]
        lines.append(f"| {kind} | {len(group)} | {sum(row['ties'] > 0 for row in group)} | "
                     f"{sum(bool(row['wrong']) for row in group)} | {sum(not row['lost'] for row in group)} | "
                     + (f"{sum(row['mixed'] > 0 for row in group)} |" if group and group[0]["mixed"] is not None else "not asked |"))
    return "\n".join(lines)


def main():
    args = seeded.arguments(__doc__, "out/loops", "0-49", "kinds", KINDS)
    if None in [loops.rendered(args, seed) for seed in args.seeds]:
        return 1
    cases = itertools.product(args.seeds, args.kinds, OFFSETS)
    rows, failed = seeded.collect(args, lambda *case: one(args, *case), cases)
    print(table(rows, args.kinds))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
