#!/usr/bin/env python3
"""How good a prior is on models that no training touched, beside three baselines.

    scores.py --config CLASS.yaml --weights WEIGHTS.pt|configs/priors/CLASS --train VIEWS --test VIEWS --out FOLDER

The decoder's values are calibrated on the validation designs first (fit_calibration), as the export does it too.
IoU at 64^3 of the solid that the program makes of the values (cut.py), at one threshold, calibrated like the share that layers keep on the training's
validation designs (also of the values above it alone, and made canonical as the program does it next); IoU at 32^3 by Pix3D's protocol
(box of values >= 0.1, cube, trilinear to 32^3, best mean over thresholds 0.01 ... 0.49), of that solid and of the values; Chamfer
distance between 1,024 points each of the surface voxels, box centred, longest side 1, one way plus the other (Pix3D takes them
from marching cubes). Baselines: mean training shape; the training model of the view nearest by latents; for every test
model the nearest of all training shapes (oracle).
"""
import argparse
import json
import pathlib

import numpy as np
import torch
import torch.nn.functional as F
import yaml

import cut
import data
import nets
import plots
import restart


KEPT = (0.0, 0.1, 0.25, 0.5)  # of what is expected in a layer: what is tried


def iou(ours, truth):
    both = (ours & truth).reshape(len(ours), -1).sum(1)
    either = (ours | truth).reshape(len(ours), -1).sum(1)
    return (both.float() / either.clamp(min=1)).numpy()


def at_32(volume):
    """One volume [64, 64, 64] of values in [0, 1] by Pix3D's protocol."""
    inside = torch.nonzero(volume >= 0.1)
    if len(inside) == 0:
        return torch.zeros(32, 32, 32)
    low, high = inside.min(0).values, inside.max(0).values + 1
    box = volume[low[0]:high[0], low[1]:high[1], low[2]:high[2]]
    side = int(max(box.shape))
    cube = torch.zeros(side, side, side)
    corner = [(side - s) // 2 for s in box.shape]
    cube[corner[0]:corner[0] + box.shape[0], corner[1]:corner[1] + box.shape[1],
         corner[2]:corner[2] + box.shape[2]] = box
    return F.interpolate(cube[None, None], size=(32, 32, 32), mode="trilinear", align_corners=True)[0, 0]


def canonical(solid, longest=62):
    """Each of [N, 64, 64, 64] scaled to the longest side of all models and centred; nearest neighbour."""
    scaled = torch.zeros_like(solid)
    for ours, out in zip(solid, scaled):
        inside = torch.nonzero(ours)
        if len(inside) == 0:
            continue
        low, high = inside.min(0).values, inside.max(0).values + 1
        sides = [max(1, round(int(side) * longest / int((high - low).max()))) for side in high - low]
        box = ours[low[0]:high[0], low[1]:high[1], low[2]:high[2]].float()
        box = F.interpolate(box[None, None], size=sides, mode="nearest")[0, 0] > 0.5
        corner = [(64 - side) // 2 for side in sides]
        out[corner[0]:corner[0] + sides[0], corner[1]:corner[1] + sides[1], corner[2]:corner[2] + sides[2]] = box
    return scaled


def set_iou_32(ours, truth):
    """Best mean over thresholds, and the IoU of each pair there. The truth is cut at the same threshold."""
    small_ours = torch.stack([at_32(v) for v in ours])
    small_truth = torch.stack([at_32(v) for v in truth])
    best = (-1.0, None, None)
    for level in np.arange(0.01, 0.495, 0.01):
        each = iou(small_ours >= level, small_truth >= level)
        if each.mean() > best[0]:
            best = (float(each.mean()), float(level), each)
    return best


def surface_points(solid, random, count=1024):
    solid = solid.bool()
    inner = solid.clone()
    for axis in range(3):
        for shift in (1, -1):
            inner &= torch.roll(solid, shift, axis)
    points = torch.nonzero(solid & ~inner).numpy().astype(np.float32)
    if len(points) == 0:
        return None
    points = points[random.choice(len(points), count, replace=len(points) < count)]
    low, high = points.min(0), points.max(0)
    return (points - (low + high) / 2) / max(1e-6, float((high - low).max()))


def chamfer(a, b, random):
    p, q = surface_points(a, random), surface_points(b, random)
    if p is None or q is None:
        return float("nan")
    apart = torch.cdist(torch.from_numpy(p), torch.from_numpy(q))
    return float(apart.min(1).values.mean() + apart.min(0).values.mean())


def mean_of_known(values):
    """Nothing where no view gave a solid: JSON has no word for what is not a number."""
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else None


@torch.no_grad()
def run(model, views, use_depth, numbers=None, decode=True):
    shares, latents, azimuths = [], [], []
    numbers = np.arange(len(views)) if numbers is None else numbers
    for start in range(0, len(numbers), 64):
        some = numbers[start:start + 64]
        crops, viewpoint = views.inputs(some, use_depth)
        z, azimuth, _ = model.encoder(crops, model.sketch(crops), viewpoint)
        latents.append(z)
        azimuths.append(nets.azimuth_of(azimuth))
        if decode:
            shares.append(torch.sigmoid(model.decoder(z)).half())
    return (torch.cat(shares).float() if decode else None), torch.cat(latents), torch.cat(azimuths)


@torch.no_grad()
def fit_calibration(model, check, most=256, voxels=4096):
    """Scale and offset of the logits by which a value is the share of voxels that are solid among those of that value
    (Platt 1999), on designs that did not take part. Dice losses make networks surer than they are right, and thin legs
    fall below the 0.1 at which Pix3D's protocol takes the box."""
    random = torch.Generator().manual_seed(1)
    numbers = np.linspace(0, len(check) - 1, min(most, len(check))).astype(int)
    logits, truth = [], []
    for use_depth in (True, False):
        for start in range(0, len(numbers), 64):
            some = numbers[start:start + 64]
            crops, viewpoint = check.inputs(some, use_depth)
            latents, _, _ = model.encoder(crops, model.sketch(crops), viewpoint)
            chosen = torch.randint(64 ** 3, (len(some), voxels), generator=random)
            logits.append(model.decoder(latents).reshape(len(some), -1).gather(1, chosen).reshape(-1))
            truth.append(check.voxels(check.owner[some]).reshape(len(some), -1).gather(1, chosen).reshape(-1))
    logits, truth = torch.cat(logits).double(), torch.cat(truth).double()
    basis, fit = torch.stack([logits, torch.ones_like(logits)], 1), torch.tensor([1.0, 0.0], dtype=torch.float64)
    for _ in range(30):
        share = torch.sigmoid(basis @ fit)
        hessian = basis.t() @ (basis * (share * (1 - share))[:, None]) + 1e-9 * torch.eye(2, dtype=torch.float64)
        fit -= torch.linalg.solve(hessian, basis.t() @ (share - truth))
    scale, offset = (float(value) for value in fit)
    if not (np.isfinite(scale) and np.isfinite(offset) and scale > 0):
        raise SystemExit(f"the networks' values cannot be calibrated (scale {scale}, offset {offset}): train longer")
    return scale, offset


def joined(latents):
    """Geometric median of views' latents, as src/deepslam/propose/joined_encoding.cc finds it."""
    middle = latents.mean(0)
    for _ in range(30):
        weight = 1 / (latents - middle).norm(dim=1, keepdim=True).clamp(min=1e-6)
        middle = (weight * latents).sum(0) / weight.sum()
    return middle


def mean_shape(views):
    total = torch.zeros(64, 64, 64)
    for m in range(len(views.models)):
        total += views.voxels([m])[0]
    return total / len(views.models)


def best_threshold(shares, truth):
    levels = [n / 40 for n in range(2, 32)]
    scores = [iou(shares > level, truth).mean() for level in levels]
    return levels[int(np.argmax(scores))]


def best_kept(shares, truth, threshold):
    """How much of what is expected in a layer is kept, scored on shapes made canonical as the program does it next: there a
    lost leg costs most. A tenth keeps the leg, and thin; half keeps it as thick as it is, and blurs what stands above it."""
    scores = {kept: iou(canonical(cut.cut(shares, threshold, kept)), truth).mean() for kept in KEPT}
    return max(scores, key=scores.get)


def nearest_shapes(train, truth):
    """For each test model the IoU of the nearest training shape [models]."""
    best = np.zeros(len(truth))
    flat = truth.reshape(len(truth), -1).float()
    size = flat.sum(1)
    for start in range(0, len(train.models), 32):
        some = train.voxels(np.arange(start, min(start + 32, len(train.models)))).reshape(-1, 64 ** 3).float()
        both = flat @ some.t()
        best = np.maximum(best, (both / (size[:, None] + some.sum(1)[None] - both)).max(1).values.numpy())
    return best


def azimuth_figures(azimuth, views):
    camera, symmetry = views.camera(np.arange(len(views)))[:, 0], views.symmetry(np.arange(len(views)))
    told = symmetry == 1
    if not bool(told.any()):
        return {}, {}
    apart = azimuth - camera
    apart = torch.atan2(apart.sin(), apart.cos())
    errors = np.degrees(apart.abs()[told].numpy())
    # A model whose views agree on another azimuth than the data's is turned in the data.
    residual = {}
    for m, model in enumerate(views.models):
        rows = torch.from_numpy(views.owner == m)
        if model["symmetry"] == 1 and bool(rows.any()):
            residual[model["id"]] = float(np.degrees(torch.atan2(apart[rows].sin().mean(), apart[rows].cos().mean())))
    return {"median_deg": float(np.median(errors)), "within_22_5": float(np.mean(errors < 22.5)),
            "within_30": float(np.mean(errors < 30)), "flipped": float(np.mean(errors > 135))}, residual


def score_input(model, train, check, test, use_depth, latent_bank, random):
    check_numbers = np.linspace(0, len(check) - 1, min(len(check), 512)).astype(int)
    check_shares, _, _ = run(model, check, use_depth, check_numbers)
    check_truth = check.voxels(check.owner[check_numbers]).bool()
    threshold = best_threshold(check_shares, check_truth)
    kept = best_kept(check_shares[::2], check_truth[::2], threshold)
    shares, latents, azimuth = run(model, test, use_depth)
    truth = test.voxels(test.owner).bool()
    solid = cut.cut(shares, threshold, kept)
    each = iou(solid, truth)
    mean_32, level_32, _ = set_iou_32(solid.float(), truth.float())
    result = {"threshold": threshold, "kept_of_expected": kept, "iou64": float(each.mean()), "iou64_by_threshold": float(iou(shares > threshold, truth).mean()),
              "iou64_canonical": float(iou(canonical(solid), truth).mean()),
              "iou32": mean_32, "threshold32": level_32, "iou32_of_values": set_iou_32(shares, truth.float())[0],
              "chamfer": mean_of_known([chamfer(s, t, random) for s, t in zip(solid, truth)])}
    result["azimuth"], result["azimuth_residual_deg"] = azimuth_figures(azimuth, test)
    per_model, ten, median_ten, best_ten, spread = {}, [], [], [], []
    for m, entry in enumerate(test.models):
        rows = np.flatnonzero(test.owner == m)
        solid = truth[rows[0]][None]
        some = latents[rows[:10]]
        together = torch.sigmoid(model.decoder(torch.stack([some.mean(0), joined(some)]))).detach()
        mean, median = iou(cut.cut(together, threshold, kept), solid.expand(2, -1, -1, -1))
        ten.append(float(mean))
        median_ten.append(float(median))
        best_ten.append(float(each[rows[:10]].max()))
        spread.append(float(each[rows].std()))
        per_model[entry["id"]] = {"iou64": float(each[rows].mean()), "least": float(each[rows].min()),
                                  "most": float(each[rows].max()), "mean_latent_of_10": ten[-1],
                                  "median_latent_of_10": median_ten[-1]}
    result.update(mean_latent_of_10=float(np.mean(ten)), median_latent_of_10=float(np.mean(median_ten)),
                  best_of_10=float(np.mean(best_ten)), spread_over_views=float(np.mean(spread)), models=per_model)
    bank, owner = latent_bank[use_depth]
    nearest = owner[torch.cdist(latents, bank).argmin(1).numpy()]
    found = torch.cat([torch.from_numpy(iou(train.voxels([n]).bool(), truth[v][None]))
                       for v, n in enumerate(nearest)]).numpy()
    result["retrieval_by_latent"] = {"iou64": float(found.mean()),
                                     "iou32": set_iou_32(train.voxels(nearest).float(), truth.float())[0]}
    return result, each, found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", required=True)
    parser.add_argument("--weights", required=True)
    parser.add_argument("--train", action="append", required=True)
    parser.add_argument("--test", action="append", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    random = np.random.default_rng(1)
    config = yaml.safe_load(pathlib.Path(arguments.config).read_text(encoding="utf-8"))
    train, check = data.Views(arguments.train, "train"), data.Views(arguments.train, "validate")
    model = nets.Prior(config["width"]).eval()
    restart.read(model, arguments.weights)
    test = data.Views(arguments.test)
    if {m["id"] for m in test.models} & {m["id"] for m in train.models + check.models}:
        raise SystemExit("a test model is among those of training")
    truth = test.voxels(np.arange(len(test.models))).bool()
    mean = mean_shape(train)
    scale, offset = fit_calibration(model, check)
    nets.calibrate(model, scale, offset)
    # The best of its thresholds on the very test: no other baseline is favoured so.
    level = best_threshold(mean[None].expand(len(truth), -1, -1, -1), truth)
    mean_solid = cut.cut(mean[None], level, 0.5)[0]
    mean_ious = max((iou(shape[None].expand_as(truth), truth) for shape in (mean > level, mean_solid)), key=np.mean)
    nearest_ious = nearest_shapes(train, truth)
    scores = {"calibration": {"scale": scale, "offset": offset}, "test_models": len(test.models), "test_views": len(test), "train_models": len(train.models),
              "mean_shape": {"iou64": float(mean_ious.mean()),
                             "iou32": max(set_iou_32(shape[None].expand(len(truth), -1, -1, -1), truth.float())[0]
                                          for shape in (mean, mean_solid.float())),
                             "threshold": level},
              "oracle": {"iou64": float(nearest_ious.mean())}}
    numbers = np.sort(random.choice(len(train), min(len(train), 6000), replace=False))
    bank = {depth: (run(model, train, depth, numbers, decode=False)[1], train.owner[numbers]) for depth in (True, False)}
    rows = {}
    for depth, name, row in ((True, "colour_and_depth", "network"), (False, "colour", "network, colour alone")):
        scores[name], each, found = score_input(model, train, check, test, depth, bank, random)
        rows[row] = each
        if depth:
            rows["retrieval by latent"] = found
    # Each view of a model has the same baseline.
    rows.update({"mean shape": mean_ious[test.owner], "nearest training shape": nearest_ious[test.owner]})
    scores["histograms"] = {name: plots.histogram(ious) for name, ious in rows.items()}
    out = pathlib.Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    (out / "scores.json").write_text(json.dumps(scores, indent=1), encoding="utf-8")
    plots.draw_histogram(scores["histograms"], out / "scores.png")
    short = {k: ({a: b for a, b in v.items() if a not in ("models", "azimuth_residual_deg")} if isinstance(v, dict) else v)
             for k, v in scores.items() if k != "histograms"}
    print(json.dumps(short, indent=1))


if __name__ == "__main__":
    main()
