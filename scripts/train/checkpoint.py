"""A training's state in few bytes: all numbers in 16 bits. What that rounds is far below what a step changes, and four copies of
six million weights come back from another machine in 51 MB."""
import io

import torch

import pieces

NAME = "checkpoint"
HALF_MOST = 6e4  # above it a value has no 16-bit float


def narrowed(tensor):
    if tensor.dtype == torch.float32 and float(tensor.abs().max() if tensor.numel() else 0) < HALF_MOST:
        return tensor.half()
    return tensor


def half_of(model):
    return {name: narrowed(value) for name, value in model.state_dict().items()}


def write(folder, model, mean, optimizer, state):
    moments = optimizer.state_dict()
    # Second moments go below what half precision holds; bfloat16 has the range.
    moments["state"] = {number: {name: value.bfloat16() if name.startswith("exp_avg") else value for name, value in entry.items()}
                        for number, entry in moments["state"].items()}
    content = io.BytesIO()
    torch.save({"model": half_of(model), "mean": half_of(mean),
                "optimizer": moments, "state": state}, content)
    pieces.write(folder, NAME, state["step"], content.getvalue())


def read(folder, model, mean, optimizer, device):
    """The state, or nothing where there is no checkpoint."""
    found = pieces.read(folder, NAME)
    if found is None:
        return None
    saved = torch.load(io.BytesIO(found[1]), map_location=device, weights_only=True)
    model.load_state_dict(saved["model"])
    mean.load_state_dict(saved["mean"])
    moments = saved["optimizer"]
    moments["state"] = {number: {name: value.float() for name, value in entry.items()} for number, entry in moments["state"].items()}
    optimizer.load_state_dict(moments)
    return saved["state"]
