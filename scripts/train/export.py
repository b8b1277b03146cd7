#!/usr/bin/env python3
"""Weights become what the program runs: sketch.onnx, encoder.onnx, decoder.onnx; beside them MODEL_CARD.md and scores.json.

    export.py --config CLASS.yaml --weights WEIGHTS.pt --scores SCORES.json --curve CURVE.json --data VIEWS [--credit TEXT] --out FOLDER

Weights are stored in 8 bits (narrow_weights.py) and computed with as 32-bit floats. ONNX Runtime must give the numbers that
PyTorch gives with the same weights, and nearly those with the ones that are stored, or nothing is written.
"""
import argparse
import collections
import json
import pathlib
import platform

import onnx
import torch
import yaml

import decoder_gradient
import narrow_weights
import nets

TOLERANCE = 2e-3


def export(module, inputs, names_in, names_out, file, metadata):
    """How far ONNX Runtime is from PyTorch: with the same weights, and with those of few bytes, which are written."""
    batch = {name: {0: "batch"} for name in names_in + names_out}
    torch.onnx.export(module, inputs, str(file), input_names=names_in, output_names=names_out, dynamic_axes=batch,
                      opset_version=17, dynamo=False)
    model = onnx.load(str(file))
    for key, value in metadata.items():
        entry = model.metadata_props.add()
        entry.key, entry.value = key, str(value)
    given = {name: value.numpy() for name, value in zip(names_in, inputs)}
    run = lambda model: narrow_weights.session_of(model).run(names_out, given)
    ours = module(*inputs)
    ours = [value.detach().numpy() for value in (ours if isinstance(ours, tuple) else (ours,))]
    worst = narrow_weights.difference(run(model), ours)
    if not worst < TOLERANCE:
        raise SystemExit(f"{file}: ONNX Runtime differs from PyTorch by {worst:.2g}")
    narrow = narrow_weights.narrow(model)
    narrower = narrow_weights.difference(run(narrow), ours)
    if not narrower < narrow_weights.TOLERANCE:
        raise SystemExit(f"{file}: 8 bits change the outputs by {narrower:.2g} of their range")
    onnx.save(narrow, str(file))
    return worst, narrower


def card(config, scores, curve, heads, given, worst, weights):
    names = collections.OrderedDict([("colour_and_depth", "colour and depth crop"), ("colour", "colour crop alone")])
    models = [m for head in heads for m in head["models"]]
    source = collections.Counter((m["source"], m["split"]) for m in models)
    credits = sorted(set(given) | {m["credit"] for m in models if m["source"] == "catalogue"})
    lines = [f"# Shape prior: {config['class']}", "",
             "Three networks: `sketch.onnx` (crop to depth, normals, silhouette), `encoder.onnx` (crop and sketch to 100 "
             "latents and viewpoint), `decoder.onnx` (latents to 64^3). Made by `scripts/train/train.sh "
             f"{config['class']}`. Weights: BSD 3-Clause like the code; the data are credited below.", "",
             f"Weights: {weights}. ONNX Runtime agrees with PyTorch to {worst[0]:.1e} of the range, with the 8 bits that are "
             f"stored to {worst[1]:.1e}.", "", "## Scores", "",
             f"{scores['test_views']} views with faults of {scores['test_models']} products that no training "
             "touched (configs/withheld_models.yaml); protocols in scripts/train/scores.py.", "",
             "| | IoU 64 | IoU 32 | Chamfer | mean latent of 10 | best of 10 | spread over views |",
             "|---|---|---|---|---|---|---|"]
    for key, name in names.items():
        s = scores[key]
        chamfer = "-" if s["chamfer"] is None else f"{s['chamfer']:.3f}"
        lines.append(f"| {name} | {s['iou64']:.3f} | {s['iou32']:.3f} | {chamfer} | {s['mean_latent_of_10']:.3f} | "
                     f"{s['best_of_10']:.3f} | {s['spread_over_views']:.3f} |")
    both = scores["colour_and_depth"]
    lines += [f"| mean training shape | {scores['mean_shape']['iou64']:.3f} | {scores['mean_shape']['iou32']:.3f} | | | | |",
              f"| retrieval by latent | {both['retrieval_by_latent']['iou64']:.3f} | "
              f"{both['retrieval_by_latent']['iou32']:.3f} | | | | |",
              f"| nearest training shape (oracle) | {scores['oracle']['iou64']:.3f} | | | | | |", ""]
    for key, name in names.items():
        lines.append(f"- Made canonical, as the program places them, {name}: IoU 64 {scores[key]['iou64_canonical']:.3f}; values above the "
                     f"threshold alone, as the network has them: {scores[key]['iou64_by_threshold']:.3f}.")
    for key, name in names.items():
        if "median_latent_of_10" in scores[key]:
            lines.append("- Ten views together by the geometric median of their latents, as the program takes it, "
                         f"{name}: IoU 64 {scores[key]['median_latent_of_10']:.3f}.")
    for key, name in names.items():
        a = scores[key]["azimuth"]
        if a:
            lines.append(f"- Azimuth, {name}: median {a['median_deg']:.1f} deg, within 22.5 deg {a['within_22_5']:.2f}, "
                         f"within 30 deg {a['within_30']:.2f}, flipped {a['flipped']:.3f}.")
    last = curve["curve"][-1]["step"] if curve["curve"] else curve["step"]
    lines += ["", "## Training", "",
              f"{last} steps of {config['batch']} views in {curve['seconds'] / 3600:.1f} h on {platform.machine()}, "
              f"PyTorch {torch.__version__}; seed {config['seed']}.",
              *(f"Before that: {line}" for line in curve.get("before", [])),
              "Models: " + ", ".join(f"{n} {s} ({p})" for (s, p), n in sorted(source.items())) + ".", "",
              "## Limits", "",
              "Rendered furniture only; thin parts are often lost; a cut crop does not show what was cut; sizes come from "
              "depth, not from the network.", "", "## Credits of the data", ""]
    lines += [f"- {line}" for line in credits]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("config", "weights", "scores", "curve", "out"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--data", action="append", required=True)
    parser.add_argument("--credit", action="append", default=[], help="of meshes of yours: makers and licence, for the card")
    arguments = parser.parse_args()
    config = yaml.safe_load(pathlib.Path(arguments.config).read_text(encoding="utf-8"))
    scores = json.loads(pathlib.Path(arguments.scores).read_text(encoding="utf-8"))
    curve = json.loads(pathlib.Path(arguments.curve).read_text(encoding="utf-8"))
    heads = [json.loads((pathlib.Path(folder) / "training_views.json").read_text(encoding="utf-8"))
             for folder in arguments.data]
    if not arguments.credit and any(m["source"] == "folder" for head in heads for m in head["models"]):
        raise SystemExit("--credit: meshes of a folder took part; say who made them and under which licence")
    model = nets.load(arguments.weights, config["width"])
    nets.calibrate(model, **scores["calibration"])
    torch.manual_seed(1)
    crop, sketch, latents = torch.rand(2, 7, 128, 128), torch.rand(2, 5, 64, 64), torch.randn(2, nets.LATENTS)
    viewpoint = torch.tensor([[0.6, 0.3, 1.0], [0.8, 0.0, 0.0]])
    out = pathlib.Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    common = {"format": "deepslam/prior", "version": 1, "class": config["class"]}
    cuts = {name + suffix: scores[key][name] for key, suffix in (("colour_and_depth", ""), ("colour", "_colour"))
            for name in ("threshold", "kept_of_expected")}
    differences = (
        export(model.sketch, (crop,), ["crop"], ["sketch"], out / "sketch.onnx", dict(common, role="sketch")),
        export(model.encoder, (crop, sketch, viewpoint), ["crop", "sketch", "sight"],
               ["latents", "azimuth", "elevation"], out / "encoder.onnx", dict(common, role="encoder")),
        export(model.decoder, (latents,), ["latents"], ["logits"], out / "decoder.onnx",
               dict(common, role="decoder", **cuts)))
    worst = [max(values) for values in zip(*differences)]
    decoder_gradient.add_to(out / "decoder.onnx")
    weights = ", ".join(f"{name} {sum(p.numel() for p in getattr(model, name).parameters()) / 1e6:.2f} M"
                        for name in ("sketch", "encoder", "decoder"))
    (out / "MODEL_CARD.md").write_text(card(config, scores, curve, heads, arguments.credit, worst, weights), encoding="utf-8")
    (out / "scores.json").write_text(json.dumps(scores, indent=1) + "\n", encoding="utf-8")
    print(f"{out}: {sum(f.stat().st_size for f in out.glob('*.onnx')) / 1e6:.1f} MB, largest difference {worst[0]:.1e}, of the 8 bits {worst[1]:.1e}")


if __name__ == "__main__":
    main()
