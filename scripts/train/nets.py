"""The networks of a shape prior, in the manner of Pix3D (Sun et al. 2018).

  sketch    crop [N, 7, 128, 128] -> sketch [N, 5, 64, 64]: depth, normal (3), silhouette (logit)
  encoder   crop, sketch -> latents [N, 100], azimuth [N, 24] (logits of bins), elevation [N, 1]
  decoder   latents -> logits [N, 64, 64, 64], index order x (front), y, z as the program's voxel grids

The planes of a crop are those of src/deepslam/propose/network_crop.h. The decoder is 2-D with the 64 places along x as
channels: as good as a 3-D one and an order of magnitude faster.
"""
import math

import torch
from torch import nn

CROP, SKETCH, GRID, LATENTS, BINS = 128, 64, 64, 100, 24


def down(channels_in, channels_out):
    return nn.Sequential(
        nn.Conv2d(channels_in, channels_out, 4, 2, 1, bias=False), nn.BatchNorm2d(channels_out), nn.ReLU(True))


def up(channels_in, channels_out):
    return nn.Sequential(
        nn.ConvTranspose2d(channels_in, channels_out, 4, 2, 1, bias=False), nn.BatchNorm2d(channels_out), nn.ReLU(True))


class Sketch(nn.Module):
    def __init__(self, planes=7):
        super().__init__()
        self.e1, self.e2 = down(planes, 24), down(24, 48)
        self.e3, self.e4 = down(48, 96), down(96, 128)
        self.d4, self.d3, self.d2 = up(128, 96), up(192, 48), up(96, 32)
        self.out = nn.Conv2d(56, 5, 3, 1, 1)

    def forward(self, crop):
        a = self.e1(crop)
        b = self.e2(a)
        c = self.e3(b)
        y = torch.cat([self.d4(self.e4(c)), c], 1)
        y = torch.cat([self.d3(y), b], 1)
        y = torch.cat([self.d2(y), a], 1)
        return self.out(y)


class Encoder(nn.Module):
    def __init__(self, planes=7):
        super().__init__()
        self.body = nn.Sequential(
            down(5 + 4 * planes, 64), down(64, 128), down(128, 192), down(192, 256), nn.Flatten(),
            nn.Linear(256 * 16, 144), nn.ReLU(True))
        self.latents = nn.Linear(144, LATENTS)
        self.azimuth = nn.Linear(144, BINS)
        self.elevation = nn.Linear(144, 1)

    def forward(self, crop, sketch):
        features = self.body(torch.cat([sketch, nn.functional.pixel_unshuffle(crop, 2)], 1))
        return self.latents(features), self.azimuth(features), self.elevation(features)


class Decoder(nn.Module):
    def __init__(self):
        super().__init__()
        self.first = nn.Sequential(nn.Linear(LATENTS, 256 * 16), nn.ReLU(True))
        self.body = nn.Sequential(
            up(256, 192), up(192, 128), up(128, 128), nn.ConvTranspose2d(128, GRID, 4, 2, 1))

    def forward(self, latents):
        return self.body(self.first(latents).view(-1, 256, 4, 4))


class Prior(nn.Module):
    def __init__(self):
        super().__init__()
        self.sketch, self.encoder, self.decoder = Sketch(), Encoder(), Decoder()

    def forward(self, crop):
        sketch = self.sketch(crop)
        latents, azimuth, elevation = self.encoder(crop, sketch)
        return self.decoder(latents), latents, azimuth, elevation, sketch


def azimuth_of(logits):
    """Angle (rad) of the bins' strongest neighbourhood; bin k has its middle at k * 360 / 24 degrees."""
    share = torch.softmax(logits, 1)
    best = share.argmax(1, keepdim=True)
    near = (best + torch.arange(-1, 2, device=logits.device)) % BINS
    weight = share.gather(1, near)
    angle = near * (2 * math.pi / BINS)
    return torch.atan2((weight * angle.sin()).sum(1), (weight * angle.cos()).sum(1))
