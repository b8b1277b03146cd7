#!/usr/bin/env python3
"""Teaches an encoder to look at the mirror image of a view as well, after its training.

    mirror.py --config CLASS.yaml --weights WEIGHTS.pt --data VIEWS [--data MORE] --out MIRROR.pt

Furniture that is mirrored is furniture, so a view and its mirror image are two readings of one shape, and their errors
are not the same ones. What makes the latents of a shape out of those of its mirror image is fitted by least squares to
training views, half of them without depth; the encoder gives the mean of both readings from then on, at twice its cost.
"""
import argparse
import pathlib

import numpy as np
import torch
import yaml

import data
import nets
import restart

RIDGE = 0.1


@torch.no_grad()
def readings(model, views, numbers):
    """Latents of the views and of their mirror images, [n, 100] each; every second batch by colour alone."""
    ours, theirs = [], []
    for start in range(0, len(numbers), 32):
        crops, viewpoint = views.inputs(numbers[start:start + 32], use_depth=start % 64 == 0)
        latents = model.encoder.look_twice(crops, model.sketch(crops), viewpoint)[0]
        ours.append(latents[0])
        theirs.append(latents[1])
    return torch.cat(ours), torch.cat(theirs)


@torch.no_grad()
def fit(model, views, count):
    """Sets the encoder's `mirror`. Returns the share of the latents' variance that it does not explain."""
    numbers = np.sort(np.random.default_rng(1).choice(len(views), min(count, len(views)), replace=False))
    ours, theirs = (latents.double() for latents in readings(model, views, numbers))
    given, wanted = torch.cat([theirs, ours]), torch.cat([ours, theirs])  # the map is its own inverse
    basis = torch.cat([given, torch.ones(len(given), 1, dtype=torch.float64)], 1)
    ridge = RIDGE * torch.eye(basis.shape[1], dtype=torch.float64)
    found = torch.linalg.solve(basis.t() @ basis + ridge, basis.t() @ wanted)
    model.encoder.mirror.weight.copy_(found[:-1].t())
    model.encoder.mirror.bias.copy_(found[-1])
    return float(((basis @ found - wanted) ** 2).sum() / ((wanted - wanted.mean(0)) ** 2).sum())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("config", "weights", "out"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--data", action="append", required=True)
    parser.add_argument("--count", type=int, default=4000, help="views it is fitted to")
    arguments = parser.parse_args()
    config = yaml.safe_load(pathlib.Path(arguments.config).read_text(encoding="utf-8"))
    model = nets.Prior(config["width"]).eval()
    restart.read(model, arguments.weights)
    left = fit(model, data.Views(arguments.data, "train"), arguments.count)
    torch.save(model.state_dict(), arguments.out)
    print(f"{arguments.out}: {1 - left:.3f} of the latents' variance is that of the mirror images' latents")


if __name__ == "__main__":
    main()
