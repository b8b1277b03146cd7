"""What one view says of the places of a model, laid out as the model lies: the sketch's depth, looked up from a canonical grid.

A plain network would have to turn what it sees by the azimuth it sees it at. Here the turn is done by geometry, so that what
is learned of one side holds for all (GenRe, Zhang et al. 2018, unprojects for the same reason).
"""
import math

import torch
from torch import nn

PLACES, GRID, LONGEST, SKETCH = 32, 64, 62, 64
NEAREST = 0.25  # of the object's distance
REACH = 8 / LONGEST  # of the longest side: how far in front of a surface and behind it places are told apart


def direction_of(logits):
    """Cosine and sine of the bins' strongest neighbourhood."""
    bins = logits.shape[1]
    share = torch.softmax(logits, 1)
    near = (share.argmax(1, keepdim=True) + torch.arange(-1, 2, device=logits.device)) % bins
    weight, angle = share.gather(1, near), near * (2 * math.pi / bins)
    cosine, sine = (weight * angle.cos()).sum(1), (weight * angle.sin()).sum(1)
    length = (cosine * cosine + sine * sine).sqrt().clamp(min=1e-6)
    return cosine / length, sine / length


def camera_axes(azimuth, elevation):
    """Right, down and forward of the camera in the model's frame (x front, z up), [N, 3, 3] by rows. The camera stands at
    the azimuth from the front, counter-clockwise from above, and looks down by the elevation."""
    cosine, sine = direction_of(azimuth)
    level, steep, zero = elevation[:, 0].cos(), elevation[:, 0].sin(), torch.zeros_like(cosine)
    right = torch.stack([-sine, cosine, zero], 1)
    down = torch.stack([steep * cosine, steep * sine, -level], 1)
    forward = torch.stack([-level * cosine, -level * sine, -steep], 1)
    return torch.stack([right, down, forward], 1)


class Unproject(nn.Module):
    """sketch [N, 5, 64, 64], azimuth (logits), elevation, spread [N, 1] -> [N, 2 * 32, 32, 32]: for each place of the
    model's cube, its x as channels, whether it lies within the silhouette, and how far behind the seen surface, in [-1, 1].

    The cube is the box of what the sketch shows, as wide as its longest side: parts out of sight move it, which is left
    to the networks. `spread` is the crop's side over the focal length, none or 0 for parallel lines of sight: of a sofa two metres
    wide and seen from two metres, the far end is half as large as the near one."""

    def __init__(self):
        super().__init__()
        pixel = (torch.arange(SKETCH) + 0.5) / SKETCH - 0.5
        v, u = torch.meshgrid(pixel, pixel, indexing="ij")
        self.register_buffer("pixels", torch.stack([u.reshape(-1), v.reshape(-1)]), persistent=False)
        place = ((torch.arange(PLACES) + 0.5) / PLACES - 0.5) * GRID / LONGEST
        places = torch.stack(torch.meshgrid(place, place, place, indexing="ij")).reshape(3, -1)
        self.register_buffer("places", places, persistent=False)

    def forward(self, sketch, azimuth, elevation, spread=None):
        inside, depth = torch.sigmoid(sketch[:, 4:5]), sketch[:, :1]
        axes = camera_axes(azimuth, elevation)
        spread = (torch.zeros_like(elevation) if spread is None else spread)[:, :, None]
        ray = self.pixels * (1 + spread * depth.flatten(2)).clamp(min=NEAREST)
        seen = axes[:, :2].transpose(1, 2) @ ray + axes[:, 2:].transpose(1, 2) * depth.flatten(2)
        shown = inside.flatten(2) > 0.5
        low = torch.where(shown, seen, torch.full_like(seen, 2.0)).amin(2)
        high = torch.where(shown, seen, torch.full_like(seen, -2.0)).amax(2)
        side = (high - low).amax(1).clamp(min=0.1)[:, None, None]
        at = axes @ (0.5 * (low + high)[:, :, None] + side * self.places)
        pixel = at[:, :2] / (1 + spread * at[:, 2:]).clamp(min=NEAREST)
        grid = (2 * pixel).transpose(1, 2)[:, :, None]
        found = nn.functional.grid_sample(torch.cat([inside, inside * depth], 1), grid, mode="bilinear",
                                          padding_mode="zeros", align_corners=False)[..., 0]
        within, surface = found[:, :1], found[:, 1:] / found[:, :1].clamp(min=1e-3)
        behind = ((at[:, 2:] - surface) / (REACH * side)).clamp(-1, 1) * within
        return torch.cat([within, behind], 1).view(-1, 2 * PLACES, PLACES, PLACES)
