"""Training views that are rendered while others are learnt from: shards by processes beside, and the pool they go to."""
import ctypes
import json
import pathlib
import shutil
import signal
import subprocess

import numpy as np
import torch

import data

END_WITH_PARENT = 1  # PR_SET_PDEATHSIG


def end_with_parent():
    ctypes.CDLL(None).prctl(END_WITH_PARENT, signal.SIGTERM)


class Renderers:
    """Keeps `processes` renderers at work, shard after shard, until `ahead` shards wait to be taken."""

    def __init__(self, command, folder, first, processes, ahead=3, most_failures=3):
        """`command(shard, folder)`: what renders a shard into a folder that is not there yet."""
        self.command, self.folder, self.next = command, pathlib.Path(folder), first
        self.processes, self.ahead, self.failures_left = processes, ahead, most_failures
        self.running, self.ready = {}, []
        self.folder.mkdir(parents=True, exist_ok=True)

    def start(self):
        while len(self.running) < self.processes and len(self.ready) + len(self.running) < self.ahead:
            out = self.folder / f"shard_{self.next}"
            for left in (out, out.with_name(out.name + ".partial")):
                shutil.rmtree(left, ignore_errors=True)
            with open(self.folder / "render.log", "ab") as log:
                self.running[out] = subprocess.Popen(self.command(self.next, out), stdout=log, stderr=log,
                                                     preexec_fn=end_with_parent)
            self.next += 1

    def take(self):
        """A shard's folder, or nothing while none is finished. Whoever takes it removes it."""
        for out, process in list(self.running.items()):
            if process.poll() is None:
                continue
            del self.running[out]
            if process.returncode == 0:
                self.ready.append(out)
                continue
            self.failures_left -= 1
            if self.failures_left <= 0:
                last = (self.folder / "render.log").read_text(encoding="utf-8", errors="replace").strip().splitlines()[-1:]
                raise SystemExit(f"views cannot be rendered (exit {process.returncode}): {' '.join(last) or 'no message'}; "
                                 f"see {self.folder / 'render.log'}")
        self.start()
        return self.ready.pop(0) if self.ready else None

    def stop(self):
        for process in self.running.values():
            process.terminate()
        for process in self.running.values():
            process.wait()
        self.running = {}


ARRAYS = (*data.CROP, *data.SKETCH, "camera")


class Ring:
    """The last `room` views of a kind, as bytes on the device."""

    def __init__(self, room, device):
        self.room, self.device, self.arrays, self.at, self.count = room, device, {}, 0, 0

    def add(self, rows):
        """`rows`: name -> array [n, ...]."""
        count = min(len(rows["camera"]), self.room)
        places = torch.from_numpy((self.at + np.arange(count)) % self.room).to(self.device)
        for name, values in rows.items():
            values = torch.from_numpy(np.ascontiguousarray(values[:count]))
            if name not in self.arrays:
                self.arrays[name] = torch.zeros((self.room, *values.shape[1:]), dtype=values.dtype, device=self.device)
            self.arrays[name][places] = values.to(self.device)
        self.at, self.count = (self.at + count) % self.room, min(self.room, self.count + count)

    def rows(self, name, places):
        return self.arrays[name][places]


class Pool:
    """Views of generated designs and of products, so many of both together; the oldest go when new ones come."""

    def __init__(self, room, share_of_products, device):
        products = max(1, int(room * share_of_products))
        self.rings, self.device = {"made": Ring(max(1, room - products), device), "product": Ring(products, device)}, device
        self.share_of_products, self.seen = share_of_products, 0

    def __len__(self):
        return sum(ring.count for ring in self.rings.values())

    def add(self, folder):
        """The training views of a folder; designs that validate are left out."""
        folder = pathlib.Path(folder)
        models = json.loads((folder / "training_views.json").read_text(encoding="utf-8"))["models"]
        of_view = np.load(folder / "model.npy")
        arrays = {name: np.load(folder / f"{name}.npy", mmap_mode="r") for name in ARRAYS}
        bits = np.load(folder / "voxels.npy", mmap_mode="r")
        symmetry = np.array([model["symmetry"] for model in models], np.int64)
        for kind, ring in self.rings.items():
            wanted = np.array([m["split"] == "train" and (m["source"] == "generated") == (kind == "made") for m in models], bool)
            numbers = np.flatnonzero(wanted[of_view])
            if len(numbers):
                rows = {name: values[numbers] for name, values in arrays.items()}
                ring.add(dict(rows, voxels=bits[of_view[numbers]], symmetry=symmetry[of_view[numbers]]))
                self.seen += len(numbers)

    def batch(self, size, depth_dropped, random):
        """As data.batch, drawn on the device."""
        products, made = self.rings["product"], self.rings["made"]
        count = int(round(size * self.share_of_products)) if made.count and products.count else size if products.count else 0
        drawn = [(ring, torch.from_numpy(random.integers(ring.count, size=n)).to(self.device))
                 for ring, n in ((made, size - count), (products, count)) if n]
        rows = lambda name: torch.cat([ring.rows(name, places) for ring, places in drawn])
        camera = rows("camera")
        flip, dropped = (torch.from_numpy(random.random(size) < share).to(self.device) for share in (0.5, depth_dropped))
        return data.varied(data.crop_planes(*map(rows, data.CROP)), data.sketch_planes(*map(rows, data.SKETCH)),
                           data.unpacked(rows("voxels")), camera[:, :5], data.viewpoint_of(camera), rows("symmetry"), flip, dropped)
