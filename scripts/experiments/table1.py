#!/usr/bin/env python3
"""The paper's Table 1 over many objects: first candidate against the selected one, networks alone and all sources.

    scripts/experiments/table1.py [--seeds 0-3] [--work out/table1] [--variants networks,all,measured] [--page FILE] [-- RUN OPTIONS]

Every seed is a room of its own: twelve chairs and four tables out of the products that neither the library nor training
may hold (configs/withheld_models.yaml), turned at random, seen on a walk round them with a Kinect-like sensor (640 x 480,
120 frames). Each capture is reconstructed three times up to `mesh`, the front end once: `networks` has the shape networks'
candidates alone, of eight views each, `all` those of the library, the networks and the own measurement, as by default, `measured` those
without networks. All rooms are scored as one set by
`deepslam eval selection` and `eval objects`; `closed` is the share of the way from the initial to the oracle that selection goes.
Captures, workspaces and JSON lie in --work and are used again; tables go to stdout. --page FILE writes what came out of all
variants, with the command and the commit, between the lines `<!-- table1 -->` and `<!-- /table1 -->` of that document. Needs nothing
beyond Python 3.
"""
import json
import math
import pathlib
import random
import re
import shutil
import sys

import seeded
from cases import commit
from seeded import ROOT
from tables import num_found, selection_table, table

WITHHELD = ROOT / "configs/withheld_models.yaml"
NUM_CHAIRS, NUM_TABLES = 12, 4
RINGS = ((5, 0.9), (11, 2.2))  # pieces of furniture, and metres from the middle
REACH_M = 3.7
FRONT_END = ("track", "ground", "layout", "detect", "segment", "associate")
VARIANTS = {"networks": ["--set", "propose.network=true", "--set", "propose.networks.max_views=8", "--set", "propose.retrieval=false",
                         "--set", "propose.fused=false"],
            "all": ["--set", "propose.network=true"],
            "measured": ["--set", "propose.network=false"]}
NAMES = {"networks": "networks alone", "all": "all sources, the default", "measured": "without networks"}
ROWS = ("initial", "selected", "oracle", "with refinement")  # those that a page shows
BEGIN, END = "<!-- table1 -->\n", "<!-- /table1 -->\n"


def withheld(class_name):
    """Ids of the withheld products of a class."""
    part = re.search(rf"^  # {class_name}\n((?:  [ -].*\n?)*?)(?=  # |\Z)", WITHHELD.read_text(), re.MULTILINE)
    return re.findall(r'id: "([^"]+)"', part.group(1))


def scene(seed):
    """The room's YAML: furniture in two rings, the camera on a circle round them."""
    draw = random.Random(seed)
    models = [("chair", m) for m in draw.sample(withheld("chair"), NUM_CHAIRS)]
    models += [("table", m) for m in draw.sample(withheld("table"), NUM_TABLES)]
    draw.shuffle(models)
    objects = []
    for count, radius in RINGS:
        turn = draw.uniform(0, 2 * math.pi)
        for k in range(count):
            class_name, model = models[len(objects)]
            angle, at = turn + 2 * math.pi * k / count, radius + draw.uniform(-0.08, 0.08)
            objects.append(f'  - {{class: {class_name}, model: "{model}", position_m: '
                           f'[{at * math.cos(angle):.3f}, {at * math.sin(angle):.3f}], yaw_deg: {draw.uniform(-180, 180):.1f}}}')
    start = draw.uniform(0, 2 * math.pi)
    around = [start + 2 * math.pi * k / 8 for k in range(8)]
    points = ", ".join(f"[{REACH_M * math.cos(a):.3f}, {REACH_M * math.sin(a):.3f}, {draw.uniform(1.45, 1.65):.3f}]" for a in around)
    looks = ", ".join(f"[{0.9 * math.cos(a):.3f}, {0.9 * math.sin(a):.3f}, 0.5]" for a in around)
    return f"""seed: {2000 + seed}
frames: 120
frames_per_s: 6
camera: {{preset: kinect_v1}}
room:
  size_m: [{2 * REACH_M + 1.6:.2f}, {2 * REACH_M + 1.2:.2f}, 2.7]
  floor: {draw.choice(["wood", "tiles", "carpet"])}
  posters: 9
  ambient: 0.42
lights:
  - {{position_m: [1.8, 1.5, 2.65], side_m: 1.0, power: 2.6}}
  - {{position_m: [-1.8, -1.5, 2.65], side_m: 1.0, power: 2.6}}
objects:
{chr(10).join(objects)}
walk:
  closed: true
  laps: 1.05
  points_m: [{points}]
  look_at_m: [{looks}]
  shake_m: 0.012
  shake_deg: 0.7
"""


class Driver:
    scene = staticmethod(scene)
    variants = VARIANTS

    def __init__(self, args):
        self.args = args

    def call(self, name, *command):
        return seeded.call(self.args, name, *command)

    def capture(self, seed):
        return self.args.work / "captures" / f"{seed:03d}"

    def workspace(self, seed, variant):
        return self.args.work / "workspaces" / f"{seed:03d}.{variant}"

    def render(self, seed):
        file = self.args.work / "scenes" / f"{seed:03d}.yaml"
        made = (self.capture(seed) / "groundtruth.txt").exists()
        if made and file.exists() and file.read_text() == self.scene(seed):
            return True
        shutil.rmtree(self.capture(seed), ignore_errors=True)
        file.write_text(self.scene(seed))
        return self.call(f"{seed:03d}", "synth", file, "-o", self.capture(seed))

    def reconstruct(self, seed, variant, origin):
        """Up to `mesh`. The front end is taken over from `origin`; the program checks by content what of it holds."""
        workspace = self.workspace(seed, variant)
        if origin and origin != variant and not workspace.exists():
            source = self.workspace(seed, origin)
            workspace.mkdir()
            for stage in FRONT_END:
                shutil.copytree(source / stage, workspace / stage)
            shutil.copy(source / "workspace.json", workspace)
        return self.call(f"{seed:03d}.{variant}", "run", self.capture(seed), "-o", workspace, "--progress", "none",
                         "--threads", self.args.threads, *self.variants[variant], *self.args.run_options, "--until", "mesh")

    def score(self, variant, seeds, kind="selection"):
        result = self.args.work / "results" / f"{variant}{'' if kind == 'selection' else '.' + kind}.json"
        pairs = [path for seed in seeds for path in (self.workspace(seed, variant), self.capture(seed))]
        if not pairs or not self.call(variant, "eval", kind, *pairs, "--json", result):
            return None
        return json.loads(result.read_text())


def way_closed(selection, row_name):
    """Share of the way from the initial candidate to the oracle, in IoU."""
    iou = {row["row"]: row["iou"] for row in selection["rows"]}
    way = iou["oracle"] - iou["initial"]
    return (iou[row_name] - iou["initial"]) / way if way > 0 else float("nan")


def less_initial(value):
    return "{mean:+.3f} [{low:.3f}, {high:.3f}]".format(**value)


def page_part(scored, command, commit):
    """`scored`: variant -> (selection, objects), as `deepslam eval` writes them."""
    rows, found = [], []
    for variant, (selection, objects) in scored.items():
        by_name = {row["row"]: row for row in selection["rows"] if row["num_objects"] > 0}
        for name in ROWS:
            if row := by_name.get(name):
                rows.append([f"{NAMES[variant]}: {name}", row["num_objects"], f'{row["iou"]:.3f}', less_initial(row["iou_minus_initial"]),
                             f'{row["chamfer"]:.3f}', less_initial(row["chamfer_minus_initial"])])
        summary = objects["summary"]
        found.append([NAMES[variant], summary["num_true"], num_found(objects), summary["num_mapped"], summary["num_placed"]])
    return "\n".join([f"`{command}`, commit {commit}:", "",
                      table(["", "objects", "IoU", "less initial, 95 %", "CD", "less initial, 95 %"], rows), "",
                      table(["", "true", "found", "mapped", "within 20 cm, 20 deg, 20 %"], found), ""])


def write_page(page, part):
    text = page.read_text(encoding="utf-8")
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(END) < text.index(BEGIN):
        sys.exit(f"{page}: the lines {BEGIN.strip()} and {END.strip()} have to stand there once, in this order")
    page.write_text(text[:text.index(BEGIN) + len(BEGIN)] + part + text[text.index(END):], encoding="utf-8")


def add_page(parser):
    parser.add_argument("--page", type=pathlib.Path, help="a document whose part between <!-- table1 --> and <!-- /table1 --> is written")


def command_of(args, variants):
    return (f"scripts/experiments/table1.py --seeds {args.seeds_text} --variants {','.join(variants)}"
            + (" -- " + " ".join(args.run_options) if args.run_options else ""))


def main():
    args = seeded.arguments(__doc__, "out/table1", "0-3", "variants", VARIANTS, add_page)
    driver = Driver(args)
    rendered = [seed for seed in args.seeds if driver.render(seed)]
    complete, scored = len(rendered) == len(args.seeds), {}
    for variant in args.variants:
        done = [seed for seed in rendered if driver.reconstruct(seed, variant, args.variants[0])]
        selection = driver.score(variant, done)
        complete = complete and len(done) == len(rendered) and selection is not None
        if selection is None:
            continue
        print(f"{variant}: seeds {', '.join(map(str, done))}; closed {100 * way_closed(selection, 'selected'):.0f} %\n")
        print(selection_table(selection) + "\n", flush=True)
        objects = driver.score(variant, done, "objects")
        complete = complete and objects is not None
        if objects is not None:
            scored[variant] = selection, objects
            if args.page:
                write_page(args.page, page_part(scored, command_of(args, scored), commit()))
    return 0 if complete else 1


if __name__ == "__main__":
    sys.exit(main())
