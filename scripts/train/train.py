#!/usr/bin/env python3
"""Trains the networks of one class. Stops and resumes at will: same data, options and device give the same course.

    train.py CLASS.yaml --data VIEWS [--data MORE] --out FOLDER [--minutes M] [--steps N] [--device cpu|cuda]
             [--start-from configs/priors/CLASS]
"""
import argparse
import copy
import json
import math
import pathlib
import time

import numpy as np
import torch
import torch.nn.functional as F
import yaml

import data
import nets
import plots
import restart


def azimuth_loss(logits, azimuth, symmetry):
    """Cross entropy with the bins near the truth; turns that leave the shape as it is count as the truth."""
    middle = torch.arange(nets.BINS, device=logits.device) * (2 * math.pi / nets.BINS)
    share = torch.zeros_like(logits)
    for turn in range(4):
        quarter = turn * math.pi / 2
        counts = (symmetry == 4) | (turn == 0) | ((symmetry == 2) & (turn == 2))
        apart = middle - azimuth[:, None] - quarter
        apart = torch.atan2(apart.sin(), apart.cos())
        share = share + counts[:, None] * torch.exp(-0.5 * (apart / math.radians(10)) ** 2)
    share = share / share.sum(1, keepdim=True)
    each = -(share * F.log_softmax(logits, 1)).sum(1)
    told = (symmetry != 0).float()  # round shapes have no azimuth
    return (each * told).sum() / told.sum().clamp(min=1)


def halved(volume, join):
    """Blocks of 2 x 2 x 2 joined to one."""
    volume = join(volume[:, 0::2], volume[:, 1::2])
    volume = join(volume[:, :, 0::2], volume[:, :, 1::2])
    return join(volume[:, :, :, 0::2], volume[:, :, :, 1::2])


def dice(share, truth):
    """Soft Dice loss of each model, and its derivative by `share`: slope * truth + level ([n, 1, 1, 1] each)."""
    share, truth = share.flatten(1), truth.flatten(1)
    common, total = torch.linalg.vecdot(share, truth), share.sum(1) + truth.sum(1) + 1
    by_truth, level = -2 / total, (2 * common + 1) / total**2
    return 1 - (2 * common + 1) / total, by_truth.view(-1, 1, 1, 1), level.view(-1, 1, 1, 1)


class Occupancy(torch.autograd.Function):
    """Of solid models [n, 64^3]: 10 * mean cross entropy; soft Dice loss; soft Dice loss at half the resolution, where
    a block's share is that of any of its voxels being solid: a leg two voxels thick that stands one voxel off is still a
    leg; and the cross entropy of the three projections along the axes (largest value of each line against whether it
    meets the model): how far a thin part reaches is known better than where in depth it stands, and bounds the model.
    Returns their weighted sum, and the four.

    Written with its derivative, as the plain form passes two dozen times over 4 million numbers, which takes longer than
    the decoder. On a processor model after model goes through the cache; a GPU wants many at once."""

    @staticmethod
    def forward(context, logits, target, weights):
        gradient = torch.empty_like(logits)
        parts = torch.zeros(4, device=logits.device, dtype=logits.dtype)
        at_once = 1 if logits.device.type == "cpu" else 64
        for logit, truth, slope in zip(logits.split(at_once), target.split(at_once), gradient.split(at_once)):
            share = torch.sigmoid(logit)
            torch.sub(share, truth, out=slope)
            parts[0] -= 10 * torch.log((1 - slope.abs()).clamp_(min=1e-7)).sum() / share[0].numel()
            slope.mul_(10 * weights[0] / share[0].numel())
            value, by_truth, level = dice(share, truth)
            parts[1] += value.sum()
            pull = (truth * by_truth).add_(level).mul_(share)
            pull.addcmul_(share * share, -level).addcmul_(share * truth * share, -by_truth)
            slope.add_(pull, alpha=weights[1])
            if weights[2]:
                empty = halved(torch.log((1 - share).clamp_(min=1e-7)), torch.add).exp_()
                truth_32 = halved(truth, torch.maximum)
                value, by_truth, level = dice(1 - empty, truth_32)
                parts[2] += value.sum()
                pull = (truth_32 * by_truth + level).mul_(empty)
                pull = pull.repeat_interleave(2, 3).repeat_interleave(2, 2)
                slope.view(-1, 32, 2, 64, 64).addcmul_(share.view(-1, 32, 2, 64, 64), pull[:, :, None], value=weights[2])
            for axis in (1, 2, 3) if weights[3] else ():
                most, met = logit.amax(axis, keepdim=True), truth.amax(axis, keepdim=True)
                each = 1 / (3 * most[0].numel())
                parts[3] += each * F.binary_cross_entropy_with_logits(most, met, reduction="sum")
                slope.addcmul_((logit == most).float(), torch.sigmoid(most) - met, value=weights[3] * each)
        context.save_for_backward(gradient.div_(len(logits)))
        parts /= len(logits)
        context.mark_non_differentiable(parts)
        return sum(weight * part for weight, part in zip(weights, parts)), parts

    @staticmethod
    def backward(context, outer, _):
        return context.saved_tensors[0] * outer, None, None


def completion_loss(solid, voxels):
    """Of 32^3 places: 10 * mean cross entropy against the share of each place that is solid, and soft Dice loss, with squares
    below the line, since these shares are no yes or no."""
    truth = F.avg_pool3d(voxels[:, None], 2)[:, 0]
    share, axes = torch.sigmoid(solid), (1, 2, 3)
    both, total = (share * truth).sum(axes), (share * share).sum(axes) + (truth * truth).sum(axes)
    return 10 * F.binary_cross_entropy_with_logits(solid, truth) + (1 - (2 * both + 1) / (total + 1)).mean()


def losses(output, item, weights):
    logits, _, azimuth, elevation, sketch, solid = output
    names = ("bce", "dice", "dice_32", "projection")
    occupancy, shape = Occupancy.apply(logits.contiguous(), item["voxels"], [weights.get(name, 0.0) for name in names])
    known, inside = item["known"].float(), item["sketch"][:, 4:5]
    parts = {
        "azimuth": azimuth_loss(azimuth, item["azimuth"], item["symmetry"]),
        "elevation": F.l1_loss(elevation[:, 0], item["elevation"]),
        "depth": ((sketch[:, :1] - item["sketch"][:, :1]).abs() * known).sum() / known.sum().clamp(min=1),
        "normal": ((sketch[:, 1:4] - item["sketch"][:, 1:4]).abs() * inside).sum() / (3 * inside.sum()).clamp(min=1),
        "silhouette": F.binary_cross_entropy_with_logits(sketch[:, 4:], inside),
        "completed": completion_loss(solid, item["voxels"]),
    }
    loss = occupancy + sum(weights[name] * value for name, value in parts.items())
    return loss, dict(parts, **dict(zip(names, shape)))


@torch.no_grad()
def follow(mean, model, step):
    """The weights that are kept are a running mean over about a thousand steps: steadier than the last ones."""
    keep = min(0.999, (1 + step) / (10 + step))
    pairs = list(zip(mean.state_dict().values(), model.state_dict().values()))
    torch._foreach_lerp_(*zip(*((ours, theirs) for ours, theirs in pairs if ours.dtype.is_floating_point)), 1 - keep)
    for ours, theirs in pairs:
        if not ours.dtype.is_floating_point:
            ours.copy_(theirs)


def set_rate(optimizer, highest, warm, progress):
    """Rises while `warm` is below 1, then falls along a cosine to a twentieth as `progress` goes to 1."""
    rate = highest * min(1.0, warm) * (0.05 + 0.475 * (1 + math.cos(math.pi * min(1.0, progress))))
    for group in optimizer.param_groups:
        group["lr"] = rate


def learn(model, optimizer, item, weights, half):
    """One step. Returns the parts of the loss."""
    with torch.autocast(item["crop"].device.type, dtype=torch.bfloat16, enabled=half):
        output = model(item["crop"], item["viewpoint"])
    loss, parts = losses([value.float() for value in output], item, weights)
    optimizer.zero_grad(set_to_none=True)
    loss.backward()
    torch.nn.utils.clip_grad_norm_(model.parameters(), 5.0)
    optimizer.step()
    return parts


def draw_numbers(views, random, size, share_of_products):
    made, products = views.groups()
    if len(made) == 0 or len(products) == 0:
        return random.choice(np.concatenate([made, products]), size)
    count = int(round(size * share_of_products))
    return np.concatenate([random.choice(made, size - count), random.choice(products, count)])


@torch.no_grad()
def validate(model, views, device, count=256):
    """Loss-free figures on designs that do not take part: IoU at the best threshold, azimuth within 30 degrees."""
    numbers = np.linspace(0, len(views) - 1, min(count, len(views))).astype(int)
    levels, ious, errors = torch.arange(0.1, 0.75, 0.05), [], []
    for start in range(0, len(numbers), 32):
        some = numbers[start:start + 32]
        logits, _, azimuth, *_ = model(views.crops(some).to(device), views.viewpoint(some).to(device))
        share, truth = torch.sigmoid(logits), views.voxels(views.owner[some]).to(device).bool()
        for level in levels:
            ours = share > level
            both, either = (ours & truth).sum((1, 2, 3)), (ours | truth).sum((1, 2, 3))
            ious.append((float(level), (both / either.clamp(min=1)).cpu().numpy()))
        apart = nets.azimuth_of(azimuth).cpu() - views.camera(some)[:, 0]
        told = views.symmetry(some) == 1
        errors.append(torch.atan2(apart.sin(), apart.cos()).abs()[told].numpy())
    best = max((float(np.mean(np.concatenate([i for l, i in ious if l == level]))), level)
               for level in sorted({l for l, _ in ious}))
    errors = np.degrees(np.concatenate(errors)) if errors else np.zeros(0)
    return {"iou64": best[0], "threshold": best[1], "azimuth_30": float(np.mean(errors < 30)) if len(errors) else None}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("config")
    parser.add_argument("--data", action="append", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after this time; run again to go on")
    parser.add_argument("--steps", type=int, help="steps in all, over which the rate falls (default: the configuration's)")
    parser.add_argument("--rate", type=float, help="highest learning rate (default: the configuration's)")
    parser.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--start-from", help="weights to begin with: weights.pt of another training, or exported networks")
    arguments = parser.parse_args()
    config = yaml.safe_load(pathlib.Path(arguments.config).read_text(encoding="utf-8"))
    torch.set_num_threads(arguments.threads)
    torch.manual_seed(config["seed"])
    out = pathlib.Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    device = torch.device(arguments.device)

    train_views, check_views = data.Views(arguments.data, "train"), data.Views(arguments.data, "validate")
    model = nets.Prior(config["width"]).to(device)
    optimizer = torch.optim.AdamW(model.parameters(), lr=config["rate"], weight_decay=config["weight_decay"], fused=True)
    mean = copy.deepcopy(model).eval()
    state = {"step": 0, "seconds": 0.0, "curve": []}
    checkpoint = out / "checkpoint.pt"
    if checkpoint.exists():
        saved = torch.load(checkpoint, map_location=device, weights_only=False)
        model.load_state_dict(saved["model"])
        mean.load_state_dict(saved["mean"])
        optimizer.load_state_dict(saved["optimizer"])
        state = saved["state"]
    elif arguments.start_from:
        some = np.linspace(0, len(train_views) - 1, min(256, len(train_views))).astype(int)
        restart.begin(model.cpu(), arguments.start_from, train_views.crops(some), train_views.viewpoint(some)).to(device)
        mean.load_state_dict(model.state_dict())
        state["before"] = restart.trainings_of(arguments.start_from)
    print(f"{len(train_views)} views of {len(train_views.models)} models, validated on {len(check_views)} of "
          f"{len(check_views.models)}; step {state['step']}, {sum(p.numel() for p in model.parameters())} weights, "
          f"{device}", flush=True)

    last_step, warm = arguments.steps or config["steps"], config["warm_steps"]
    highest_rate = arguments.rate or config["rate"]
    start, sums, half = time.monotonic(), {}, device.type == "cuda" or config.get("bfloat16", False)

    def save():
        state["seconds"] += time.monotonic() - save.since
        save.since = time.monotonic()
        aside = out / "checkpoint.pt.partial"
        torch.save({"model": model.state_dict(), "mean": mean.state_dict(), "optimizer": optimizer.state_dict(), "state": state}, aside)
        aside.replace(checkpoint)
        torch.save(mean.state_dict(), out / "weights.pt")
        (out / "curve.json").write_text(json.dumps(state, indent=1), encoding="utf-8")
        plots.draw_curves(state["curve"], out / "curves.png")
    save.since = time.monotonic()

    while state["step"] < last_step and time.monotonic() - start < 60 * arguments.minutes:
        step = state["step"]
        random = np.random.default_rng([config["seed"], step])
        numbers = draw_numbers(train_views, random, config["batch"], config["product_share"])
        item = {name: value.to(device) for name, value in
                data.batch(train_views, numbers, random, config["depth_dropped"]).items()}
        set_rate(optimizer, highest_rate, (step + 1) / warm, step / last_step)
        parts = learn(model, optimizer, item, config.get("weights", {}), half)
        follow(mean, model, step)
        for name, value in parts.items():
            sums[name] = sums.get(name, 0.0) + float(value.detach())
        state["step"] = step + 1
        if state["step"] % config["check_every"] == 0 or state["step"] == last_step:
            means = {name: value / config["check_every"] for name, value in sums.items()}
            sums = {}
            entry = dict(means, step=state["step"], **validate(mean, check_views, device))
            state["curve"].append(entry)
            save()
            print(json.dumps({k: round(v, 4) if isinstance(v, float) else v for k, v in entry.items()}), flush=True)
    save()


if __name__ == "__main__":
    main()
