"""Pictures of a training and of its scores."""
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


def draw_histogram(rows, file):
    """`rows`: name -> IoUs."""
    figure, axis = plt.subplots(figsize=(7, 4))
    for name, values in rows.items():
        axis.hist(values, bins=[n / 25 for n in range(26)], histtype="step", label=name, linewidth=1.5)
    axis.set(xlabel="IoU at 64^3", ylabel="views", title="withheld models, views with faults")
    axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(file, dpi=90)
    plt.close(figure)
