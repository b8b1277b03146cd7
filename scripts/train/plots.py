#!/usr/bin/env python3
"""Pictures of a training and of its scores.

    plots.py configs/priors/*/scores.json --out docs/evaluation/priors.svg      histograms of the IoU, a class each
"""
import argparse
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def draw_curves(curve, file):
    if not curve:
        return
    steps = [entry["step"] for entry in curve]
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4))
    for name in ("bce", "dice", "azimuth", "depth", "normal", "silhouette", "elevation"):
        left.plot(steps, [entry[name] for entry in curve], label=name)
    left.set(xlabel="step", title="losses of training", yscale="log")
    left.legend(fontsize=7)
    right.plot(steps, [entry["iou64"] for entry in curve], label="IoU 64")
    right.plot(steps, [entry["azimuth_30"] or 0 for entry in curve], label="azimuth within 30 deg")
    right.set(xlabel="step", title="designs that do not take part", ylim=(0, 1))
    right.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(file, dpi=90)
    plt.close(figure)


HISTOGRAM_BINS = 25


def histogram(ious):
    """How many lie in each twenty-fifth of [0, 1]."""
    counts = [0] * HISTOGRAM_BINS
    for value in ious:
        counts[min(HISTOGRAM_BINS - 1, int(value * HISTOGRAM_BINS))] += 1
    return counts


def draw_rows(axis, rows):
    """`rows`: name -> counts of `histogram`."""
    edges = [n / HISTOGRAM_BINS for n in range(HISTOGRAM_BINS + 1)]
    for name, counts in rows.items():
        axis.stairs(counts, edges, label=name, linewidth=1.5, fill=name == "network", alpha=0.45 if name == "network" else 1)


def draw_histogram(rows, file):
    figure, axis = plt.subplots(figsize=(7, 4))
    draw_rows(axis, rows)
    axis.set(xlabel="IoU at 64^3", ylabel="views", title="withheld models, views with faults")
    axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(file, dpi=90)
    plt.close(figure)


def draw_classes(files, file):
    """One histogram for each scores.json, in rows of three."""
    matplotlib.rcParams["svg.hashsalt"] = "deepslam"  # the same bytes each time
    figure, axes = plt.subplots((len(files) + 2) // 3, 3, figsize=(12, 3 * ((len(files) + 2) // 3)), squeeze=False)
    for axis in axes.flat[len(files):]:
        axis.set_axis_off()
    for axis, path in zip(axes.flat, files):
        scores = json.loads(path.read_text(encoding="utf-8"))
        draw_rows(axis, scores["histograms"])
        axis.set(xlabel="IoU at 64^3", ylabel="views", xlim=(0, 1),
                 title=f"{path.parent.name}: {scores['test_views']} views of {scores['test_models']}")
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="lower center", ncols=5, fontsize=8)
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scores", nargs="+", type=pathlib.Path)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    draw_classes(arguments.scores, arguments.out)


if __name__ == "__main__":
    main()
