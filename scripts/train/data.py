"""Training views as `deepslam priors render` writes them (tools/training_shards.h says how)."""
import json
import pathlib

import numpy as np
import torch

from nets import mirrored_sketch

ARRAYS = ("colour", "silhouette", "depth", "height", "sketch_depth", "sketch_normal", "sketch_silhouette", "camera",
          "model", "voxels")
UNKNOWN = -10  # stands for an elevation that is not known


class Views:
    """One folder, or several that are used as one."""

    def __init__(self, folders, split=None):
        self.parts, self.models, index, owner = [], [], [], []
        for number, folder in enumerate(folders):
            folder = pathlib.Path(folder)
            head = json.loads((folder / "training_views.json").read_text(encoding="utf-8"))
            if head["format"] != "deepslam/training_views" or head["version"] != 2:
                raise SystemExit(f"{folder}: not training views of version 2; render them anew")
            part = {name: np.load(folder / f"{name}.npy", mmap_mode="r") for name in ARRAYS}
            rows = [m for m, model in enumerate(head["models"]) if split in (None, model["split"])]
            place = {m: len(self.models) + n for n, m in enumerate(rows)}
            self.models += [dict(head["models"][m], part=number, row=m) for m in rows]
            self.parts.append(part)
            model_of = np.asarray(part["model"])
            for view in np.flatnonzero(np.isin(model_of, rows)):
                index.append((number, view))
                owner.append(place[int(model_of[view])])
        self.index, self.owner = np.array(index, np.int64).reshape(-1, 2), np.array(owner, np.int64)
        self.packed = np.stack([self.parts[m["part"]]["voxels"][m["row"]] for m in self.models])

    def __len__(self):
        return len(self.index)

    def groups(self):
        """Numbers of the views of generated designs, and of those of products and meshes."""
        made = np.array([m["source"] == "generated" for m in self.models])
        return np.flatnonzero(made[self.owner]), np.flatnonzero(~made[self.owner])

    def voxels(self, models):
        bits = np.unpackbits(self.packed[models], axis=1)
        return torch.from_numpy(bits.reshape(-1, 64, 64, 64))

    def rows(self, name, numbers):
        pairs = self.index[numbers]
        return np.stack([self.parts[part][name][view] for part, view in pairs])

    def crops(self, numbers):
        """[n, 7, 128, 128] as src/deepslam/propose/network_crop.cc fills them."""
        colour = self.rows("colour", numbers).transpose(0, 3, 1, 2).astype(np.float32) / 255
        silhouette = self.rows("silhouette", numbers)[:, None].astype(np.float32) / 255
        depth = self.rows("depth", numbers)[:, None]
        known = depth > 0
        height = self.rows("height", numbers)[:, None]
        planes = [colour, silhouette, np.where(known, (depth.astype(np.float32) - 128) / 127, 0),
                  np.where(known, height.astype(np.float32) * 0.01 - 0.1, 0), known]
        return torch.from_numpy(np.concatenate([p.astype(np.float32) for p in planes], 1))

    def sketches(self, numbers):
        """[n, 5, 64, 64]: depth, normal, silhouette, and where the depth is known."""
        depth = self.rows("sketch_depth", numbers)[:, None]
        normal = self.rows("sketch_normal", numbers).transpose(0, 3, 1, 2).astype(np.float32)
        silhouette = self.rows("sketch_silhouette", numbers)[:, None].astype(np.float32) / 255
        sketch = np.concatenate([(depth.astype(np.float32) - 128) / 127, (normal - 128) / 127, silhouette], 1)
        return torch.from_numpy(sketch.astype(np.float32)), torch.from_numpy(depth > 0)

    def symmetry(self, numbers):
        return torch.tensor([self.models[m]["symmetry"] for m in self.owner[numbers]])

    def camera(self, numbers):
        pairs = self.index[numbers]
        return torch.from_numpy(np.stack([self.parts[part]["camera"][view, :5] for part, view in pairs]).astype(np.float32))

    def sight(self, numbers):
        """[n, 3] of the crop's camera: the square's side (tangent), elevation by the ground, and whether that is known."""
        camera = self.rows("camera", numbers).astype(np.float32)
        known = camera[:, 6:7] != UNKNOWN
        return torch.from_numpy(np.concatenate([camera[:, 5:6], np.where(known, camera[:, 6:7], 0), known], 1).astype(np.float32))

    def inputs(self, numbers, use_depth):
        """Crops and sight; by colour alone without depth and ground."""
        crops, sight = self.crops(numbers), self.sight(numbers)
        if not use_depth:
            drop_depth(crops, sight, slice(None))
        return crops, sight


def drop_depth(crops, sight, rows):
    """Colour alone: neither depth nor ground."""
    crops[rows, 4:] = 0
    sight[rows, 1:] = 0


def batch(views, numbers, random, depth_dropped):
    """What one step learns from; half of it mirrored left to right."""
    crops, (sketch, known), camera = views.crops(numbers), views.sketches(numbers), views.camera(numbers)
    voxels, azimuth = views.voxels(views.owner[numbers]).float(), camera[:, 0].clone()
    flip = torch.from_numpy(random.random(len(numbers)) < 0.5)
    crops[flip] = crops[flip].flip(3)
    sketch[flip] = mirrored_sketch(sketch[flip])
    known[flip] = known[flip].flip(3)
    voxels[flip] = voxels[flip].flip(2)
    azimuth[flip] *= -1
    sight = views.sight(numbers)
    drop_depth(crops, sight, torch.from_numpy(random.random(len(numbers)) < depth_dropped))
    return {"crop": crops, "sight": sight, "sketch": sketch, "known": known, "voxels": voxels, "azimuth": azimuth,
            "elevation": camera[:, 1], "symmetry": views.symmetry(numbers)}
