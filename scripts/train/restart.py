"""Weights to begin a training with: those of an earlier one (.pt), or a folder of exported networks (configs/priors/chair).

The export folds normalisation into the convolutions before it. What was folded is set up anew such that the networks
compute what they computed, and that every unit's spread over real crops is the normalisation's again, as training needs it.
"""
import pathlib

import onnx
import torch
from torch import nn

import narrow_weights


def trainings_of(source):
    """What the model card of exported networks says of the trainings behind them, the last one first; empty for other weights."""
    card = pathlib.Path(source) / "MODEL_CARD.md"
    if not card.exists():
        return []
    section = card.read_text(encoding="utf-8").partition("## Training\n")[2].partition("\n## ")[0]
    return [line.removeprefix("Before that: ") for line in section.splitlines() if " steps of " in line]


def module_of(output):
    """"/body/body.0/body.0.0/Conv_output_0" -> "body.0.0", "/completion/d1/d1.0/Conv_output_0" -> "completion.d1.0"."""
    names = []
    for part in output.split("/")[1:-1]:
        if names and part.startswith(names[-1] + "."):
            names.pop()
        names.append(part)
    return ".".join(names)


def unfold(network, model):
    """Fills `network`; returns the normalisations that are ones by now."""
    values, state, ones = narrow_weights.constants_of(model), network.state_dict(), []
    for name in state:
        if name in values:
            state[name] = torch.from_numpy(values[name].copy())
    for node in model.graph.node:
        if node.op_type != "Conv" or len(node.input) < 3 or not node.input[1].startswith("onnx::"):
            continue
        place = module_of(node.output[0])
        block, number = place.rsplit(".", 1)
        after = f"{block}.{int(number) + 1}"
        norm = network.get_submodule(after)
        state[f"{place}.weight"] = torch.from_numpy(values[node.input[1]].copy())
        state[f"{after}.weight"] = torch.ones(norm.num_features)
        state[f"{after}.bias"] = torch.from_numpy(values[node.input[2]].copy())
        state[f"{after}.running_mean"] = torch.zeros(norm.num_features)
        state[f"{after}.running_var"] = torch.full((norm.num_features,), 1 - norm.eps)
        ones.append(norm)
    network.load_state_dict(state)
    return ones


@torch.no_grad()
def respread(norm, values):
    """The same function, with the mean and variance of `values` as what it takes off and divides by."""
    mean, spread = values.mean((0, 2, 3)), values.var((0, 2, 3), unbiased=False)
    norm.bias.add_(mean)
    norm.weight.copy_((spread + norm.eps).sqrt())
    norm.running_mean.copy_(mean)
    norm.running_var.copy_(spread)


@torch.no_grad()
def revive(encoder, crops, sketches):
    """Units of the narrow layer that are silent on all crops begin anew, and nothing listens to them yet."""
    *_, narrow, active = encoder.body
    fed = encoder.body[:-2](encoder.planes(crops, sketches))
    silent = (active(narrow(fed)) > 0).float().mean(0) < 0.005
    fresh = nn.Linear(narrow.in_features, narrow.out_features)
    narrow.weight[silent], narrow.bias[silent] = fresh.weight[silent], fresh.bias[silent]
    for head in (encoder.latents, encoder.azimuth, encoder.elevation):
        head.weight[:, silent] = 0


def read(model, source):
    """`model` (nets.Prior) with the weights of `source`, computing what they compute. Parts that networks of before do not have stay as
    they were made, which adds nothing. Returns the normalisations that are ones by now: none of those of a file of weights."""
    source = pathlib.Path(source)
    if source.is_file():
        lacking = model.load_state_dict(torch.load(source, map_location="cpu", weights_only=True), strict=False)
        if lacking.unexpected_keys:
            raise SystemExit(f"{source}: weights of other networks: {lacking.unexpected_keys[0]}")
        return []
    return [norm for name in ("sketch", "encoder", "decoder")
            for norm in unfold(getattr(model, name), onnx.load(str(source / f"{name}.onnx")))]


def begin(model, source, crops, viewpoint):
    """`model` with the weights of `source`, ready to learn; `crops` are some hundred of the training's, `viewpoint` theirs."""
    learning = model.training
    norms, seen = read(model.eval(), source), {}
    nn.init.zeros_(model.encoder.mirror.weight)  # it is of latents that will be others
    if not norms:
        return model.train(learning)
    hooks = [norm.register_forward_pre_hook(lambda norm, given: seen.__setitem__(norm, given[0])) for norm in norms]
    with torch.no_grad():
        model(crops, viewpoint)
    for hook in hooks:
        hook.remove()
    for norm in norms:
        respread(norm, seen[norm])
    with torch.no_grad():
        revive(model.encoder, crops, model.sketch(crops))
    return model.train(learning)
