"""A batch of captures as one picture: how many things of each class, and the plan of every room.

    python3 batch_plot.py ROOMS_OUT [PICTURE]

ROOMS_OUT is what `deepslam batch` wrote; the picture goes to ROOMS_OUT/batch.png by default. Needs matplotlib. The cells (# %%)
run one by one in editors that know them, and as a notebook.
"""
# %% What is to be drawn
import collections
import pathlib
import sys

import matplotlib

import deepslam

if __name__ == "__main__" and "ipykernel" not in sys.modules:
    matplotlib.use("Agg")  # no window
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "rooms_out")
picture = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else folder / "batch.png"

# %% Open it; captures that failed are told and left out
batch = deepslam.open_batch(folder)
for each in batch.captures:
    print(f"{each.name}: {each.state} {each.verdict} {dict(each.objects)} {each.reason}")
scenes = {each.name: each.open() for each in batch.done}


# %% How many things of each class: a bar for every class, piled up by capture
def draw_numbers(axes: Axes) -> None:
    classes = sorted({thing.class_name for scene in scenes.values() for thing in scene.objects})
    left = [0] * len(classes)
    for name, scene in scenes.items():
        counts = collections.Counter(thing.class_name for thing in scene.objects)
        axes.barh(classes, [counts[kind] for kind in classes], left=left, label=name)
        left = [a + counts[kind] for a, kind in zip(left, classes)]
    axes.invert_yaxis()
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("things")
    if scenes:
        axes.legend(fontsize="small")


# %% A plan: walls, openings, boxes of objects with their fronts, the camera path
OPENING_COLOURS = {"door": "tab:brown", "window": "tab:blue", "passage": "tab:green"}
FOOTPRINT = [0, 1, 3, 2]  # corners of a box's lower side, in turn


def draw_plan(axes: Axes, name: str, scene: deepslam.Scene) -> None:
    if len(scene.ground_outline_m):
        axes.add_patch(Polygon(scene.ground_outline_m, facecolor="0.94", edgecolor="none"))
    if scene.layout is not None:
        for wall in scene.layout.walls:
            axes.plot(*zip(wall.from_m, wall.to_m), color="0.2", linewidth=2.5, alpha=0.3 + 0.7 * wall.confidence)
        for opening in scene.layout.openings:
            axes.plot(*zip(opening.from_m, opening.to_m), color=OPENING_COLOURS[opening.kind], linewidth=3)
    for thing in scene.objects:
        colour = [channel / 255 for channel in scene.class_colours.get(thing.class_name, (150, 150, 150))]
        axes.add_patch(Polygon(thing.box.corners_m[FOOTPRINT, :2], facecolor=colour, edgecolor="0.2", alpha=0.7))
        x, y = thing.box.centre_m[:2]
        axes.annotate(thing.name, (x, y), ha="center", va="center", fontsize="xx-small")
    axes.plot(*scene.trajectory.positions_m[:, :2].T, color="tab:red", linewidth=0.7)
    axes.set_title(f"{name}: {scene.verdict}", fontsize="medium")
    axes.set_xlabel("m")
    axes.set_aspect("equal")
    axes.autoscale_view()


# %% All in one picture, three plans a row
COLUMNS = 3
rows = -(-len(scenes) // COLUMNS)
figure = plt.figure(figsize=(12, 3 + 4 * rows), layout="constrained")
grid = figure.add_gridspec(rows + 1, COLUMNS, height_ratios=[3] + [4] * rows)
draw_numbers(figure.add_subplot(grid[0, :]))
for number, (name, scene) in enumerate(scenes.items()):
    draw_plan(figure.add_subplot(grid[1 + number // COLUMNS, number % COLUMNS]), name, scene)
figure.savefig(picture, dpi=110)
print(picture)
