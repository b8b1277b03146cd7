"""Training views as `deepslam priors render` writes them (tools/training_shards.h says how)."""
import json
import pathlib

import numpy as np
import torch

from nets import mirrored_sketch

ARRAYS = ("colour", "silhouette", "depth", "height", "sketch_depth", "sketch_normal", "sketch_silhouette", "camera",
          "model", "voxels")
UNKNOWN = -10  # stands for an elevation that is not known


CROP = ("colour", "silhouette", "depth", "height")
SKETCH = ("sketch_depth", "sketch_normal", "sketch_silhouette")


def crop_planes(colour, silhouette, depth, height):
    """Bytes of the arrays -> [n, 7, 128, 128] as src/deepslam/propose/network_crop.cc fills them."""
    known = (depth > 0)[:, None]
    planes = [colour.permute(0, 3, 1, 2).float() / 255, silhouette[:, None].float() / 255,
              torch.where(known, (depth[:, None].float() - 128) / 127, 0), torch.where(known, height[:, None].float() * 0.01 - 0.1, 0),
              known.float()]
    return torch.cat(planes, 1)


def sketch_planes(depth, normal, silhouette):
    """Bytes -> [n, 5, 64, 64]: depth, normal, silhouette; and where the depth is known."""
    depth = depth[:, None]
    sketch = [(depth.float() - 128) / 127, (normal.permute(0, 3, 1, 2).float() - 128) / 127, silhouette[:, None].float() / 255]
    return torch.cat(sketch, 1), depth > 0


def unpacked(bits):
    """[n, 32768] bytes -> [n, 64, 64, 64] of 0 and 1, the first in the highest bit."""
    places = torch.arange(7, -1, -1, device=bits.device, dtype=torch.uint8)
    return (bits[:, :, None] >> places & 1).view(-1, 64, 64, 64)


def viewpoint_of(camera):
    """[n, 3] of the crop's camera: the square's side (tangent), elevation by the ground, and whether that is known."""
    known = camera[:, 6:7] != UNKNOWN
    return torch.cat([camera[:, 5:6], torch.where(known, camera[:, 6:7], 0), known.float()], 1)


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
        return unpacked(torch.from_numpy(self.packed[models]))

    def rows(self, name, numbers):
        pairs = self.index[numbers]
        return np.stack([self.parts[part][name][view] for part, view in pairs])

    def crops(self, numbers):
        return crop_planes(*(torch.from_numpy(self.rows(name, numbers)) for name in CROP))

    def sketches(self, numbers):
        return sketch_planes(*(torch.from_numpy(self.rows(name, numbers)) for name in SKETCH))

    def symmetry(self, numbers):
        return torch.tensor([self.models[m]["symmetry"] for m in self.owner[numbers]])

    def camera(self, numbers):
        pairs = self.index[numbers]
        return torch.from_numpy(np.stack([self.parts[part]["camera"][view, :5] for part, view in pairs]).astype(np.float32))

    def viewpoint(self, numbers):
        return viewpoint_of(torch.from_numpy(self.rows("camera", numbers).astype(np.float32)))

    def inputs(self, numbers, use_depth):
        """Crops and viewpoint; by colour alone without depth and ground."""
        crops, viewpoint = self.crops(numbers), self.viewpoint(numbers)
        if not use_depth:
            drop_depth(crops, viewpoint, slice(None))
        return crops, viewpoint


def drop_depth(crops, viewpoint, rows):
    """Colour alone: neither depth nor ground."""
    crops[rows, 4:] = 0
    viewpoint[rows, 1:] = 0


def batch(views, numbers, random, depth_dropped):
    """What one step learns from; half of it mirrored left to right."""
    flip = torch.from_numpy(random.random(len(numbers)) < 0.5)
    dropped = torch.from_numpy(random.random(len(numbers)) < depth_dropped)
    return varied(views.crops(numbers), views.sketches(numbers), views.voxels(views.owner[numbers]), views.camera(numbers),
                  views.viewpoint(numbers), views.symmetry(numbers), flip, dropped)


def varied(crops, sketches, voxels, camera, viewpoint, symmetry, flip, dropped):
    """Views where `flip` mirrored left to right, where `dropped` without depth. Waits for no device."""
    def chosen(rows, those, others):
        return torch.where(rows.view(-1, *[1] * (others.dim() - 1)), those, others)

    sketch, known = sketches
    colour, depth = crops.split([4, crops.shape[1] - 4], 1)
    crops = torch.cat([colour, chosen(dropped, torch.zeros_like(depth), depth)], 1)
    viewpoint = torch.cat([viewpoint[:, :1], chosen(dropped, torch.zeros_like(viewpoint[:, 1:]), viewpoint[:, 1:])], 1)
    return {"crop": chosen(flip, crops.flip(3), crops), "viewpoint": viewpoint,
            "sketch": chosen(flip, mirrored_sketch(sketch), sketch), "known": chosen(flip, known.flip(3), known),
            "voxels": chosen(flip, voxels.flip(2), voxels).float(), "azimuth": chosen(flip, -camera[:, 0], camera[:, 0]),
            "elevation": camera[:, 1], "symmetry": symmetry}
