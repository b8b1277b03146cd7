"""The networks of a shape prior, in the manner of Pix3D (Sun et al. 2018).

  sketch    crop [N, 7, 128, 128] -> sketch [N, 5, 64, 64]: depth, normal (3), silhouette (logit)
  encoder   crop, sketch, viewpoint [N, 3] -> latents [N, 100], azimuth [N, 24] (logits of bins), elevation [N, 1]; the
            latents also from the sketch as it lies in the model's frame by that azimuth and elevation (unproject.py),
            and from what completes it there (Completion). Looks at the mirror image as well (mirror.py).
            Viewpoint: the square's side over the focal length, the elevation by the ground, and 1 where that is known
  decoder   latents -> logits [N, 64, 64, 64], index order x (front), y, z as the program's voxel grids

The planes of a crop are those of src/deepslam/propose/network_crop.h. The decoder is 2-D with the 64 places along x as
channels: as good as a 3-D one and an order of magnitude faster.
"""
import torch
from torch import nn

from unproject import FACINGS, GRID, MEASURES, PLACES, Unproject, direction_of

LATENTS, BINS = 100, 24
LEAK = 0.1  # behind the encoder's narrow layers: of plain units more than half died, all of those behind a zero last layer
SPREAD = 10  # about that of latents: a layer that begins at zero gets there ten times sooner


def scaled(channels, width):
    return max(8, int(round(channels * width / 8)) * 8)


def down(channels_in, channels_out):
    return nn.Sequential(
        nn.Conv2d(channels_in, channels_out, 4, 2, 1, bias=False), nn.BatchNorm2d(channels_out), nn.ReLU(True))


def up(channels_in, channels_out):
    return nn.Sequential(
        nn.ConvTranspose2d(channels_in, channels_out, 4, 2, 1, bias=False), nn.BatchNorm2d(channels_out), nn.ReLU(True))


class Sketch(nn.Module):
    def __init__(self, width, planes=7):
        super().__init__()
        a, b, c, d = (scaled(n, width) for n in (24, 48, 96, 128))
        self.e1, self.e2 = down(planes, a), down(a, b)
        self.e3, self.e4 = down(b, c), down(c, d)
        self.d4, self.d3, self.d2 = up(d, c), up(2 * c, b), up(2 * b, scaled(32, width))
        self.out = nn.Conv2d(scaled(32, width) + a, 5, 3, 1, 1)

    def forward(self, crop):
        a = self.e1(crop)
        b = self.e2(a)
        c = self.e3(b)
        y = torch.cat([self.d4(self.e4(c)), c], 1)
        y = torch.cat([self.d3(y), b], 1)
        y = torch.cat([self.d2(y), a], 1)
        return self.out(y)


def mirrored_sketch(sketch):
    """Of the mirror image: what is normal to the right is normal to the left there."""
    depth, right, others = sketch.flip(3).split([1, 1, 3], 1)
    return torch.cat([depth, -right, others], 1)


class Completion(nn.Module):
    """What is seen of the places of a model and a first guess of its latents -> how solid each of 32^3 places is (logits, [N, 32,
    32, 32], x as channels), and what the guess lacks. A guess is off by a voxel or two everywhere; here it stands beside what is
    seen of the same places, so that it can be put right place by place and not only as a whole (feedback: Carreira et al. 2016)."""

    def __init__(self, width):
        super().__init__()
        a, b, c = (scaled(n, width) for n in (64, 80, 96))
        self.d1, self.d2, self.d3 = down(2 * PLACES, a), down(a, b), down(b, c)
        self.guess = nn.Sequential(nn.Linear(LATENTS, c * 16), nn.ReLU(True))
        self.u3, self.u2, self.u1 = up(2 * c, b), up(2 * b, a), up(2 * a, a)
        self.solid = nn.Conv2d(a + 2 * PLACES, PLACES, 3, 1, 1)
        e, f, g, features = (scaled(n, width) for n in (40, 56, 80, 112))
        self.read = nn.Sequential(
            down(3 * PLACES, e), down(e, f), down(f, g), nn.Flatten(), nn.Linear(g * 16, features), nn.LeakyReLU(LEAK))
        self.lacking = nn.Linear(features, LATENTS)
        nn.init.zeros_(self.lacking.weight)  # begins as the networks without
        nn.init.zeros_(self.lacking.bias)

    def forward(self, places, latents):
        a = self.d1(places)
        b = self.d2(a)
        c = self.d3(b)
        y = torch.cat([self.guess(latents / SPREAD).view(-1, c.shape[1], 4, 4), c], 1)
        y = torch.cat([self.u3(y), b], 1)
        y = torch.cat([self.u2(y), a], 1)
        solid = self.solid(torch.cat([self.u1(y), places], 1))
        return solid, SPREAD * self.lacking(self.read(torch.cat([torch.sigmoid(solid), places], 1)))


class Encoder(nn.Module):
    def __init__(self, width, planes=7):
        super().__init__()
        a, b, c, d, features = (scaled(n, width) for n in (64, 128, 192, 256, 144))
        self.body = nn.Sequential(
            down(5 + 4 * planes, a), down(a, b), down(b, c), down(c, d), nn.Flatten(),
            nn.Linear(d * 16, features), nn.LeakyReLU(LEAK))
        self.latents = nn.Linear(features, LATENTS)
        self.azimuth = nn.Linear(features, BINS)
        self.elevation = nn.Linear(features, 1)
        self.unproject = Unproject()
        e, f, g, turned = (scaled(n, width) for n in (40, 64, 96, 96))
        self.turned = nn.Sequential(
            down(2 * PLACES, e), down(e, f), down(f, g), nn.Flatten(), nn.Linear(g * 16, turned),
            nn.LeakyReLU(LEAK))
        self.more_latents = nn.Linear(turned, LATENTS)
        self.profiles = nn.Sequential(
            nn.Linear(3 * len(FACINGS) * GRID + MEASURES, 160), nn.LeakyReLU(LEAK), nn.Linear(160, 160), nn.LeakyReLU(LEAK),
            nn.Linear(160, LATENTS))
        self.completion = Completion(width)
        self.mirror = nn.Linear(LATENTS, LATENTS).requires_grad_(False)  # latents of a mirror image -> of the view; fitted by mirror.py
        for last in (self.more_latents, self.profiles[-1], self.mirror):  # begins as the networks without
            nn.init.zeros_(last.weight)
            nn.init.zeros_(last.bias)

    def _load_from_state_dict(self, state, prefix, *others):
        for name in [name for name in state if name.startswith(prefix + "twin.")]:  # what weights of before call it
            state[prefix + "mirror" + name.removeprefix(prefix + "twin")] = state.pop(name)
        super()._load_from_state_dict(state, prefix, *others)

    @staticmethod
    def planes(crop, sketch):
        return torch.cat([sketch, nn.functional.pixel_unshuffle(crop, 2)], 1)

    def look(self, crop, sketch, viewpoint):
        """What one reading gives, and the completed places."""
        features = self.body(self.planes(crop, sketch))
        azimuth, elevation = self.azimuth(features), self.elevation(features)
        with torch.no_grad(), torch.autocast(crop.device.type, enabled=False):
            places, profiles = self.unproject(crop.float(), sketch.float(), azimuth.float(), elevation.float(), viewpoint.float())
        more = self.more_latents(self.turned(places)) + self.profiles(profiles)
        first = self.latents(features) + SPREAD * more
        if self.completion is None:
            return first, azimuth, elevation, None
        solid, lacking = self.completion(places, first)
        return first + lacking, azimuth, elevation, solid

    def look_twice(self, crop, sketch, viewpoint):
        """Latents, azimuth and elevation of the views and of their mirror images, [2, N, ...] each."""
        pairs = (crop, crop.flip(3)), (sketch, mirrored_sketch(sketch)), (viewpoint, viewpoint)
        return [both.view(2, -1, both.shape[1]) for both in self.look(*(torch.cat(pair) for pair in pairs))[:3]]

    def forward(self, crop, sketch, viewpoint):
        if not bool(self.mirror.weight.any()):
            return self.look(crop, sketch, viewpoint)[:3]
        latents, azimuth, elevation = self.look_twice(crop, sketch, viewpoint)
        azimuth_of_mirror = torch.cat([azimuth[1, :, :1], azimuth[1, :, 1:].flip(1)], 1)
        return 0.5 * (latents[0] + self.mirror(latents[1])), 0.5 * (azimuth[0] + azimuth_of_mirror), elevation.mean(0)


class Decoder(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.deep, b, c, d = (scaled(n, width) for n in (256, 192, 128, 96))
        self.first = nn.Sequential(nn.Linear(LATENTS, self.deep * 16), nn.ReLU(True))
        self.body = nn.Sequential(up(self.deep, b), up(b, c), up(c, d), nn.ConvTranspose2d(d, GRID, 4, 2, 1))

    def forward(self, latents):
        return self.body(self.first(latents).view(-1, self.deep, 4, 4))


class Prior(nn.Module):
    """width: share of the channels that every layer has; 1 for chairs and tables, less for classes of simpler shapes."""

    def __init__(self, width=1.0):
        super().__init__()
        self.sketch, self.encoder, self.decoder = Sketch(width), Encoder(width), Decoder(width)

    def forward(self, crop, viewpoint):
        sketch = self.sketch(crop)
        latents, azimuth, elevation, solid = self.encoder.look(crop, sketch, viewpoint)
        return self.decoder(latents), latents, azimuth, elevation, sketch, solid


def load(weights, width):
    """The networks of a file of weights, as they are used: not learning."""
    model = Prior(width)
    model.load_state_dict(torch.load(weights, map_location="cpu", weights_only=True))
    if not bool(model.encoder.completion.lacking.weight.any()):
        model.encoder.completion = None  # never trained: it adds nothing, and costs
    return model.eval()


@torch.no_grad()
def calibrate(model, scale, offset):
    """The decoder's logits times `scale` plus `offset`, within its last layer."""
    last = model.decoder.body[-1]
    last.weight.mul_(scale)
    last.bias.mul_(scale).add_(offset)
    return model


def azimuth_of(logits):
    """Angle (rad) of the bins' strongest neighbourhood; bin k has its middle at k * 360 / 24 degrees."""
    cosine, sine = direction_of(logits)
    return torch.atan2(sine, cosine)
