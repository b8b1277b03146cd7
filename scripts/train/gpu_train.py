#!/usr/bin/env python3
"""Trains the networks of one class for so many minutes by the clock, on views that are rendered beside (scripts/train/gpu.sh).

    gpu_train.py CLASS.yaml --kit FOLDER --work FOLDER --out FOLDER [--minutes M] [--seed N] [--cpu]

Run again on the same --out it goes on from its last checkpoint; --minutes counts all runs together, and where that time is
spent already only scores and networks are made. These are bounded by --score-minutes; weights and curves are packed before them.
"""
import argparse
import copy
import csv
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import torch
import yaml

import budget
import checkpoint
import data
import gpu_kit
import nets
import plots
import restart
import stream
import train
from results import Steps, pack

HERE = pathlib.Path(__file__).resolve().parent
SEED_STEP = 1000003  # between the seeds of shards: no two trainings meet
SCORE_MINUTES = 1.5  # with the eight of training it is done in ten


class Stopped:
    """True once somebody asked to stop."""

    def __init__(self):
        self.asked = False
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self.ask)

    def ask(self, *_):
        self.asked = True


def render_command(program, kit, config, shards, threads):
    """What renders shard `number`; the first has the seed of the configuration."""
    def command(number, out):
        return [*program, "--pack", str(kit / "models.pack"), "--class", config["class"], "--designs", str(shards["designs"]),
                "--first-design", str(number * shards["designs"]), "--views", str(shards["views_at_once"]),
                "--product-views", str(shards["views_at_once"]), "--variants", str(shards["variants"]),
                "--widened", str(shards["widened"] if config["widened"] else 0),
                "--narrowed", str(shards["narrowed"] if config["narrowed"] else 0), "--tops", str(config["tops"]),
                "--seed", str(config["seed"] + SEED_STEP * number), "--threads", str(threads), "-o", str(out)]
    return command


def render_now(command, what):
    print(f"rendering {what}", flush=True)
    outcome = subprocess.run(command, capture_output=True, text=True, preexec_fn=stream.end_with_parent, check=False)
    if outcome.returncode:
        raise SystemExit(f"{what} cannot be rendered (exit {outcome.returncode}): {(outcome.stderr or outcome.stdout).strip()[-500:]}")


class Training:
    def __init__(self, config, settings, device, out, start_from, some):
        self.config, self.settings, self.device, self.out = config, settings, device, out
        layout = torch.channels_last if device.type == "cuda" else torch.contiguous_format
        self.model = nets.Prior(config["width"])
        if start_from:
            restart.begin(self.model, start_from, *some)
        self.model = self.model.to(device, memory_format=layout)
        self.mean = copy.deepcopy(self.model).eval()
        self.optimizer = torch.optim.AdamW(self.model.parameters(), lr=settings["rate"], weight_decay=config["weight_decay"],
                                           fused=True)
        self.state = {"step": 0, "seconds": 0.0, "shards": 1, "views": 0, "curve": []}
        if start_from:
            self.state["before"] = restart.trainings_of(start_from)
        saved = checkpoint.read(out, self.model, self.mean, self.optimizer, device)
        self.state = saved or self.state
        self.half = device.type == "cuda" or config.get("bfloat16", False)
        self.sums, self.summed = {}, 0

    def step(self, pool, share):
        state = self.state
        random = np.random.default_rng([self.config["seed"], state["step"]])
        item = pool.batch(self.settings["batch"], self.config["depth_dropped"], random)
        train.set_rate(self.optimizer, self.settings["rate"], (state["step"] + 1) / self.config["warm_steps"], share)
        parts = train.learn(self.model, self.optimizer, item, self.config.get("weights", {}), self.half)
        train.follow(self.mean, self.model, state["step"])
        for name, value in parts.items():  # added up on the device, which nobody waits for
            self.sums[name] = self.sums.get(name, 0) + value.detach()
        self.summed += 1
        state["step"] += 1
        state["views"] += self.settings["batch"]

    def check(self, check_views, spent_s):
        """Losses since the last check, figures of designs that validate; written as a curve and a checkpoint."""
        losses = {name: float(value) / self.summed for name, value in self.sums.items()}
        self.sums, self.summed = {}, 0
        self.state["seconds"] = spent_s
        if losses:
            entry = dict(losses, step=self.state["step"], seconds=spent_s, **train.validate(self.mean, check_views, self.device))
            self.state["curve"].append(entry)
            print(json.dumps({k: round(v, 4) if isinstance(v, float) else v for k, v in entry.items()}), flush=True)
        checkpoint.write(self.out, self.model, self.mean, self.optimizer, self.state)


def run(training, renderers, pool, check_views, clock, every, stopped):
    """Until the time is spent. What is learnt from comes from `renderers` as it is ready."""
    started, waited = training.state["step"], 0.0
    while not clock.is_spent() and not stopped.asked:
        folder = renderers.take()
        if folder is not None:
            pool.add(folder)
            shutil.rmtree(folder)
            training.state["shards"] = renderers.next
        training.step(pool, clock.share())
        if every.is_due():
            training.check(check_views, clock.spent_s())
    training.check(check_views, clock.spent_s())
    steps = training.state["step"] - started
    print(f"{steps} steps, {pool.seen} views rendered, {steps * training.settings['batch']} learnt from", flush=True)


def write_curve(curve, out):
    if not curve:
        return
    with open(out / "curve.csv", "w", encoding="utf-8", newline="") as file:
        rows = csv.DictWriter(file, sorted({name for entry in curve for name in entry}))
        rows.writeheader()
        rows.writerows(curve)
    for suffix in ("png", "svg"):
        plots.draw_curves(curve, out / f"curves.{suffix}")


def keep_made(made, training):
    """Weights and curves in `made`. What was made of these very weights stays there; what is of others goes."""
    weights, file = checkpoint.half_of(training.mean.cpu()), made / "weights.pt"
    if not is_of(file, weights):
        shutil.rmtree(made, ignore_errors=True)
        made.mkdir(parents=True)
        torch.save(weights, file.with_suffix(".partial"))
        file.with_suffix(".partial").replace(file)
    (made / "curve.json").write_text(json.dumps(training.state, indent=1), encoding="utf-8")
    write_curve(training.state["curve"], made)


def is_of(file, weights):
    if not file.exists():
        return False
    saved = torch.load(file, map_location="cpu", weights_only=True)
    return saved.keys() == weights.keys() and all(torch.equal(saved[name], value) for name, value in weights.items())


def score(steps, arguments, config_file, base, test):
    """Networks, card and scores as train.sh makes them; whether all of it is there."""
    common = ["--config", str(config_file)]
    credits = [part for line in arguments.credit for part in ("--credit", line)]
    for name, command in (
            ("mirror.pt", ["mirror.py", *common, "--weights", "weights.pt", "--data", str(base)]),
            ("scores", ["scores.py", *common, "--weights", "mirror.pt", "--train", str(base), "--test", str(test),
                        "--threads", str(arguments.threads)]),
            ("networks", ["export.py", *common, "--weights", "mirror.pt", "--scores", "scores/scores.json", "--curve", "curve.json",
                          "--data", str(base), *credits])):
        made = steps.make(name, lambda place: [sys.executable, str(HERE / command[0]), *command[1:], "--out", str(place)])
        if not made:
            return False
    return True


def finish(training, arguments, config_file, base, test, stopped):
    """What was trained as one file: weights and curves at once, networks and scores in their place once they are made."""
    made, results = arguments.work / "made", arguments.out / "results.tar"
    keep_made(made, training)
    curves = sorted(file for suffix in ("csv", "png", "svg") for file in made.glob(f"*.{suffix}"))
    results_of = training.config["class"]
    if not (made / "networks").exists():
        pack(results, results_of, [made / "weights.pt", made / "curve.json", *curves])
    if arguments.no_scores:
        return
    steps = Steps(made, 60 * arguments.score_minutes, lambda: stopped.asked, {"OMP_NUM_THREADS": str(arguments.threads)},
                  stream.end_with_parent)
    if score(steps, arguments, config_file, base, test):
        pack(results, results_of, [*sorted((made / "networks").iterdir()), *curves, made / "scores/scores.png"])
        shutil.copy(made / "scores/scores.json", arguments.out / "scores.json")
        return
    print(f"{'stopped' if stopped.asked else 'time is spent'} before networks and scores were made; weights and curves lie in "
          f"{results}. `scripts/train/gpu.sh {results_of} --score` goes on, without a GPU too", flush=True)


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("config", type=pathlib.Path)
    for name in ("kit", "work", "out"):
        parser.add_argument(f"--{name}", type=pathlib.Path, required=True)
    parser.add_argument("--minutes", type=float, default=8, help="of training in all, the first views included")
    parser.add_argument("--score-minutes", type=float, help=f"for scores and networks, after training ({SCORE_MINUTES}; --score: no end)")
    parser.add_argument("--score", action="store_true", help="make scores and networks of what a GPU trained, without one; no training")
    parser.add_argument("--seed", type=int, help="in place of the configuration's")
    parser.add_argument("--start-from", help="networks to begin with: configs/priors/CLASS, or a weights.pt")
    parser.add_argument("--cpu", action="store_true", help="a trial without a GPU: small batches, small pool")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--save-every", type=float, default=60, help="seconds between checkpoints")
    parser.add_argument("--no-scores", action="store_true", help="weights, curves and checkpoints only")
    parser.add_argument("--credit", action="append", default=[], help="of meshes of yours: makers and licence, for the card")
    arguments = parser.parse_args()
    if arguments.score_minutes is None:
        arguments.score_minutes = math.inf if arguments.score else SCORE_MINUTES
    for name in ("kit", "work", "out"):
        setattr(arguments, name, getattr(arguments, name).resolve())
        getattr(arguments, name).mkdir(parents=True, exist_ok=True)
    return arguments


def main():
    begun, arguments, stopped = time.monotonic(), parse(), Stopped()
    config = yaml.safe_load(arguments.config.read_text(encoding="utf-8"))
    settings = yaml.safe_load((HERE / "gpu.yaml").read_text(encoding="utf-8"))["cpu" if arguments.cpu else "gpu"]
    config["seed"] = config["seed"] if arguments.seed is None else arguments.seed
    config["batch"] = settings["batch"]
    config_file = arguments.work / "config.yaml"
    config_file.write_text(yaml.safe_dump(config), encoding="utf-8")
    on_cpu = arguments.cpu or arguments.score
    if not on_cpu and not torch.cuda.is_available():
        raise SystemExit(gpu_kit.NO_GPU.format(torch.__version__))
    device = torch.device("cpu" if on_cpu else "cuda")
    torch.manual_seed(config["seed"])
    torch.set_num_threads(max(1, arguments.threads // 2) if on_cpu else arguments.threads)
    torch.backends.cuda.matmul.allow_tf32 = torch.backends.cudnn.allow_tf32 = torch.backends.cudnn.benchmark = True

    program = gpu_kit.program_of(arguments.kit)
    base, test = arguments.work / "views", arguments.work / "test"
    if not base.exists():
        render_now(render_command(program, arguments.kit, config, settings, arguments.threads)(0, base), "the first views")
    if not test.exists():
        render_now([*program, "--pack", str(arguments.kit / "models.pack"), "--class", config["class"], "--withheld",
                    "--product-views", str(config["test_views"] if not arguments.cpu else 4), "--seed", str(config["seed"]),
                    "--threads", str(arguments.threads), "-o", str(test)], "views of withheld products")
    check_views = data.Views([base], "validate")
    some = (check_views.crops(np.arange(min(256, len(check_views)))), check_views.viewpoint(np.arange(min(256, len(check_views)))))
    training = Training(config, settings, device, arguments.out, arguments.start_from, some)
    if arguments.score and not training.state["step"]:
        raise SystemExit(f"--score: {arguments.out} holds no checkpoint of a training; train first, or name its folder by --out")
    # What was spent on the first views counts as training: the minutes are those of the clock.
    before_s = training.state["seconds"] + (time.monotonic() - begun if not training.state["step"] else 0)
    clock = budget.Budget(60 * arguments.minutes, before_s)
    print(f"step {training.state['step']}, {clock.spent_s():.0f} of {clock.total_s:.0f} s spent, batches of {settings['batch']}, "
          f"{device}, {arguments.threads} threads, validated on {len(check_views)} views", flush=True)
    if not clock.is_spent() and not arguments.score:
        pool = stream.Pool(settings["pool"], config["product_share"], device)
        pool.add(base)
        processes = 2 if arguments.threads >= 4 else 1
        each = max(1, (arguments.threads - 2) // processes)
        renderers = stream.Renderers(render_command(program, arguments.kit, config, settings, each), arguments.work / "shards",
                                     training.state["shards"], processes)
        try:
            run(training, renderers, pool, check_views, clock, budget.Every(arguments.save_every), stopped)
        finally:
            renderers.stop()
    if stopped.asked:
        print(f"stopped at step {training.state['step']}; run again to go on", flush=True)
    finish(training, arguments, config_file, base, test, stopped)
    if stopped.asked:
        sys.exit(130)


if __name__ == "__main__":
    main()
