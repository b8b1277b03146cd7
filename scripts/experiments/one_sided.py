#!/usr/bin/env python3
"""Objects seen from one side only, as in captures of homes: how right the side is that no frame saw, for each source of shapes.

    scripts/experiments/one_sided.py [--seeds 0-5] [--work out/one_sided] [--variants measured,networks] [-- RUN OPTIONS]

Every seed is a room of its own with eight products that neither the library nor training may hold
(configs/withheld_models.yaml). The camera (Kinect-like, 640 x 480, 60 frames) walks 2 m along one side, so that each
object is seen from within 60 degrees; what stands at the wall faces it, chairs and tables are turned at random.
`measured` has candidates of the library and the own measurement, `networks` those of the shape networks as well; the front end
is shared. `deepslam eval selection --unseen` scores both. The table compares, over the objects that both have, the first
candidate of each source and what ends in the map: IoU (best threshold of each object), Chamfer distance, and the share of
the unseen true surface within 5 cm; then what networks change, with 95 % intervals of the paired bootstrap over objects.
"""
import json
import random
import sys

import seeded
import table1
from tables import table

WALK_HALF_M = 1.0      # half of the camera's way, along x
WALK_Y_M = -2.3        # of the way; 4.1 m to the last row, which depth has to reach
NEAREST_Y_M = -0.4     # of the objects, so that 1.9 m and more lie between: atan(1 / 1.8) is less than half of 60 degrees
ROWS = (  # y, places along x, classes that may stand there; the last row stands at the wall
    (NEAREST_Y_M, (-1.1, 0.1, 1.3), ("chair",)),
    (0.7, (-1.9, 0.0, 1.9), ("chair", "table", "table")),
    (1.8, (-1.9, 1.6), ("sofa", "cabinet", "shelf", "bed")))
WALL_Y_M = 3.6  # half the room; behind the longest bed
VARIANTS = {"measured": ["--set", "propose.network=false"], "networks": ["--set", "propose.network=true"]}
SOURCES = (("measured", "retrieval"), ("measured", "fused"), ("networks", "network"), ("networks", "mean_latent"),
           ("networks", "refined"), ("measured", "final"), ("networks", "final"))


def scene(seed):
    """The room's YAML."""
    draw = random.Random(seed)
    drawn, objects = set(), []
    for y, places, classes in ROWS:
        for x in places:
            class_name = draw.choice(classes)
            model = draw.choice([m for m in table1.withheld(class_name) if m not in drawn])
            drawn.add(model)
            # At the wall furniture faces the camera's way, which is towards -y.
            yaw = -90 if y == ROWS[-1][0] else draw.uniform(-180, 180)
            objects.append(f'  - {{class: {class_name}, model: "{model}", position_m: '
                           f'[{x + draw.uniform(-0.1, 0.1):.3f}, {y + draw.uniform(-0.1, 0.1):.3f}], yaw_deg: {yaw:.1f}}}')
    along = [WALK_HALF_M * (2 * k / 4 - 1) for k in range(5)]
    if draw.random() < 0.5:
        along.reverse()
    points = ", ".join(f"[{x:.3f}, {WALK_Y_M:.3f}, {draw.uniform(1.45, 1.65):.3f}]" for x in along)
    looks = ", ".join(f"[{draw.uniform(-0.4, 0.4) + 0.5 * x:.3f}, 0.6, 0.5]" for x in along)
    return f"""seed: {3000 + seed}
frames: 60
frames_per_s: 10
camera: {{preset: kinect_v1}}
room:
  size_m: [8.0, {2 * WALL_Y_M:.2f}, 2.7]
  floor: {draw.choice(["wood", "tiles", "carpet"])}
  posters: 6
  ambient: 0.42
lights:
  - {{position_m: [1.8, 0.5, 2.65], side_m: 1.0, power: 2.6}}
  - {{position_m: [-1.8, -0.5, 2.65], side_m: 1.0, power: 2.6}}
objects:
{chr(10).join(objects)}
walk:
  points_m: [{points}]
  look_at_m: [{looks}]
  shake_m: 0.012
  shake_deg: 0.7
"""


class Driver(table1.Driver):
    scene = staticmethod(scene)
    variants = VARIANTS

    def score(self, variant, seeds):
        result = self.args.work / "results" / f"{variant}.json"
        pairs = [path for seed in seeds for path in (self.workspace(seed, variant), self.capture(seed))]
        if not pairs or not self.call(variant, "eval", "selection", "--unseen", *pairs, "--json", result):
            return None
        return json.loads(result.read_text())


def figures(selection):
    """{(class, capture, true number): {source or 'final': (IoU, Chamfer, unseen share)}}; of each source the best scored."""
    objects = {}
    for row in selection["objects"]:
        of = objects.setdefault((row["class"], row["capture"], row["true_number"]), {})
        for candidate in row["candidates"]:
            values = (candidate["iou_peak"], candidate["chamfer"], candidate["unseen_share"])
            of.setdefault(candidate["source"], values)
            if candidate["candidate"] == row["final"]:
                of["final"] = values
    return objects


def mean_interval(values, seed=1, resamples=10000):
    """Mean and its 95 % percentile interval by the bootstrap."""
    draw = random.Random(seed)
    n = len(values)
    means = sorted(sum(draw.choices(values, k=n)) / n for _ in range(resamples))
    return sum(values) / n, means[int(0.025 * resamples)], means[int(0.975 * resamples) - 1]


def by_class(known, common):
    """What ends in the map, without networks and with them, for each class."""
    rows = []
    for class_name in sorted({key[0] for key in common}):
        keys = [key for key in common if key[0] == class_name and all("final" in known[v][key] for v in known)]
        if not keys:
            continue
        cells = []
        for n, digits, factor in ((0, 3, 1), (1, 3, 1), (2, 1, 100)):
            cells += [f"{factor * sum(known[v][key]['final'][n] for key in keys) / len(keys):.{digits}f}" for v in VARIANTS]
        rows.append([class_name, len(keys), *cells])
    return table(["class", "objects", "IoU without", "with", "CD without", "with", "unseen % without", "with"], rows)


def report(scored):
    """The tables, as Markdown."""
    known = {variant: figures(selection) for variant, selection in scored.items()}
    common = sorted(set.intersection(*(set(objects) for objects in known.values())))
    rows = []
    for variant, source in SOURCES:
        values = [known[variant][key][source] for key in common if variant in known and source in known[variant][key]]
        if values:
            means = [sum(column) / len(values) for column in zip(*values)]
            rows.append([f"{source}, {variant}" if source == "final" else source, len(values), f"{means[0]:.3f}",
                         f"{means[1]:.3f}", f"{100 * means[2]:.1f}"])
    parts = [table(["first candidate of, or in the map", "objects", "IoU", "CD", "unseen surface within 5 cm, %"], rows)]
    if len(known) == 2:
        changes = []
        for against in ("retrieval", "fused", "final"):
            pairs = [(known["networks"][key]["final"], known["measured"][key][against]) for key in common
                     if "final" in known["networks"][key] and against in known["measured"][key]]
            if not pairs:
                continue
            cells = [f"{m:+.3f} [{low:+.3f}, {high:+.3f}]" for m, low, high in
                     (mean_interval([a[n] - b[n] for a, b in pairs]) for n in (0, 1, 2))]
            changes.append([f"{against}, measured", len(pairs), *cells])
        parts.append(table(["map with networks, less", "objects", "IoU, 95 %", "CD, 95 %", "unseen share, 95 %"], changes))
        parts.append(by_class(known, common))
    return "\n\n".join(parts)


def main():
    args = seeded.arguments(__doc__, "out/one_sided", "0-5", "variants", VARIANTS)
    driver = Driver(args)
    rendered = [seed for seed in args.seeds if driver.render(seed)]
    complete = len(rendered) == len(args.seeds)
    scored = {}
    for variant in args.variants:
        done = [seed for seed in rendered if driver.reconstruct(seed, variant, args.variants[0])]
        selection = driver.score(variant, done)
        complete = complete and len(done) == len(rendered) and selection is not None
        if selection is not None:
            scored[variant] = selection
    if scored:
        print(report(scored))
    return 0 if complete else 1


if __name__ == "__main__":
    sys.exit(main())
