"""What one view says of the places of a model, laid out as the model lies: its depth, looked up from a canonical grid, and the
profiles of its surface along the model's axes.

A plain network would have to turn what it sees by the azimuth it sees it at. Here the turn is done by geometry, so that what
is learned of one side holds for all (GenRe, Zhang et al. 2018, unprojects for the same reason).
"""
import collections
import math

import torch
from torch import nn

PLACES, GRID, LONGEST, SKETCH = 32, 64, 62, 64
NEAREST = 0.25  # of the object's distance
REACH = 8 / LONGEST  # of the longest side: how far in front of a surface and behind it places are told apart
TRUSTED = 0.1  # of the crop's side: measured depth that is farther off the sketch's is another object's, or a fault
FACINGS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1))  # front, back, either side, up
MEASURES = 9
FEWEST_HEIGHTS = 50  # pixels that tell how heights in the model grow with those above the ground


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


def at_sketch(plane, known):
    """Mean of the known pixels of a crop's plane [N, 1, 128, 128] at the sketch's size, and the share of them that are known."""
    share = nn.functional.avg_pool2d(known, 2)
    return nn.functional.avg_pool2d(plane * known, 2) / share.clamp(min=1e-3), share


def best_depth(crop, sketch):
    """[N, 1, 64, 64]: the measured depth, and the sketch's where there is none or it belongs to something else. A sketch
    is twice as far off on average (sofas: 2.0 % of the crop's side, measured 1.1 %)."""
    measured, known = at_sketch(crop[:, 4:5], crop[:, 6:7])
    guessed = sketch[:, :1]
    return torch.where((known > 0) & ((measured - guessed).abs() < TRUSTED), measured, guessed)


# In the model's axes: points of the surface [N, 3, 4096], whether the sketch shows them [N, 1, 4096]; of the box of those that it
# shows the middle and the sides [N, 3, 1], and the longest side [N, 1, 1].
Seen = collections.namedtuple("Seen", "points shown middle extent side")


def measures_of(crop, seen):
    """[N, 9]: the seen box's sides, relative; by the heights above the ground its sides (m), how far above the ground it
    begins, its longest side (m), and whether the heights tell (else those are 0)."""
    height, known = (plane.flatten(2) for plane in at_sketch(crop[:, 5:6], crop[:, 6:7]))
    weight = ((known > 0) & (height > -0.05)).float() * seen.shown
    total = weight.sum(2, keepdim=True)
    told, z = (total > FEWEST_HEIGHTS).float(), seen.points[:, 2:]
    mean = lambda values: (weight * values).sum(2, keepdim=True) / total.clamp(min=1)
    mean_z, mean_height = mean(z), mean(height)
    metres = (mean((z - mean_z) * (height - mean_height)) / (mean((z - mean_z) ** 2) + 1e-5)).clamp(0.2, 6)  # for each unit
    ground = mean_z - mean_height / metres
    above = ((seen.middle[:, 2:] - 0.5 * seen.extent[:, 2:] - ground) / seen.side).clamp(-1, 1)
    size = (metres * seen.side).clamp(0, 5)
    sides = seen.extent / seen.side
    return torch.cat([sides, told * size * sides, told * above, told * size, told], 1)[:, :, 0]


class Unproject(nn.Module):
    """crop, sketch [N, 5, 64, 64], azimuth (logits), elevation [N, 1], viewpoint [N, 3] ->
      places    [N, 2 * 32, 32, 32]: for each place of the model's cube, its x as channels, whether it lies within the
                silhouette, and how far behind the seen surface, in [-1, 1]
      profiles  [N, 3 * 5 * 64 + 9]: how much surface lies at each of 64 places along x, y and z, of that which faces the
                front, the back, either side and up (a seat is a peak along z of what faces up); then measures_of()

    The cube is the box of what the sketch shows, as wide as its longest side: parts out of view move it, which is left
    to the networks. Viewpoint: how far viewing rays run apart (of a sofa two metres wide and seen from two metres, the far end is
    half as large as the near one), and the elevation by the ground, which is used where it is known."""

    def __init__(self):
        super().__init__()
        pixel = (torch.arange(SKETCH) + 0.5) / SKETCH - 0.5
        v, u = torch.meshgrid(pixel, pixel, indexing="ij")
        self.register_buffer("pixels", torch.stack([u.reshape(-1), v.reshape(-1)]), persistent=False)
        place = ((torch.arange(PLACES) + 0.5) / PLACES - 0.5) * GRID / LONGEST
        places = torch.stack(torch.meshgrid(place, place, place, indexing="ij")).reshape(3, -1)
        self.register_buffer("places", places, persistent=False)
        self.register_buffer("facings", torch.tensor(FACINGS, dtype=torch.float32), persistent=False)
        self.register_buffer("bins", torch.arange(GRID, dtype=torch.float32)[:, None], persistent=False)

    def along(self, axes, spread, depth):
        """Points of a depth [N, 1, 64, 64] in the model's axes, [N, 3, 4096]."""
        ray = self.pixels * (1 + spread * depth.flatten(2)).clamp(min=NEAREST)
        return axes[:, :2].transpose(1, 2) @ ray + axes[:, 2:].transpose(1, 2) * depth.flatten(2)

    def see(self, sketch, depth, axes, spread):
        outline, shown = self.along(axes, spread, sketch[:, :1]), sketch[:, 4:5].flatten(2) > 0
        low = torch.where(shown, outline, torch.full_like(outline, 2.0)).amin(2)[:, :, None]
        high = torch.where(shown, outline, torch.full_like(outline, -2.0)).amax(2)[:, :, None]
        side = (high - low).amax(1, keepdim=True).clamp(min=0.1)
        points = self.along(axes, spread, depth)
        return Seen(points, shown.float(), 0.5 * (low + high), (high - low).clamp(min=0), side)

    def behind_surface(self, sketch, depth, axes, spread, seen):
        inside = torch.sigmoid(sketch[:, 4:5])
        at = axes @ (seen.middle + seen.side * self.places)
        pixel = at[:, :2] / (1 + spread * at[:, 2:]).clamp(min=NEAREST)
        grid = (2 * pixel).transpose(1, 2)[:, :, None]
        found = nn.functional.grid_sample(torch.cat([inside, inside * depth], 1), grid, mode="bilinear",
                                          padding_mode="zeros", align_corners=False)[..., 0]
        within, surface = found[:, :1], found[:, 1:] / found[:, :1].clamp(min=1e-3)
        behind = ((at[:, 2:] - surface) / (REACH * seen.side)).clamp(-1, 1) * within
        return torch.cat([within, behind], 1).view(-1, 2 * PLACES, PLACES, PLACES)

    def surface_along(self, sketch, axes, seen):
        """[N, 3 * 5 * 64]; every second row and column are enough."""
        some = lambda values: values.view(-1, values.shape[1], SKETCH, SKETCH)[:, :, ::2, ::2].flatten(2)
        normals = axes.transpose(1, 2) @ some(sketch[:, 1:4])
        facing = (self.facings @ normals).clamp(min=0) * some(seen.shown)  # [N, 5, 1024]
        at = ((some(seen.points) - seen.middle) / seen.side * (LONGEST / GRID) + 0.5) * GRID - 0.5
        near = (1 - (at[:, :, None] - self.bins).abs()).clamp(min=0)  # [N, 3, 64, 1024]
        return torch.log1p(near @ facing.transpose(1, 2)[:, None]).flatten(1)

    def forward(self, crop, sketch, azimuth, elevation, viewpoint):
        depth, spread = best_depth(crop, sketch), viewpoint[:, :1, None]
        axes = camera_axes(azimuth, torch.where(viewpoint[:, 2:] > 0.5, viewpoint[:, 1:2], elevation))
        seen = self.see(sketch, depth, axes, spread)
        profiles = torch.cat([self.surface_along(sketch, axes, seen), measures_of(crop, seen)], 1)
        return self.behind_surface(sketch, depth, axes, spread, seen), profiles
