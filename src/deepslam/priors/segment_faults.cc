#include "deepslam/priors/segment_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/priors/value_noise.h"

namespace deepslam::priors {
namespace {

float Draw(Random& random, double low, double high) {
  return static_cast<float>(random.Uniform(low, high));
}
bool Chance(Random& random, double probability) { return random.Uniform() < probability; }

// Sum of four uniform numbers out of one draw: nearly normal, mean 0, deviation 1.
float QuickNormal(Random& random) {
  const std::uint64_t bits = random.Next();
  constexpr std::uint64_t kMask = 0xFFFF;  // 16 bits: four numbers of a draw
  const auto sum = static_cast<float>((bits & kMask) + (bits >> 16U & kMask) +
                                      (bits >> 32U & kMask) + (bits >> 48U & kMask));
  constexpr float kDeviation = 0.57735F;  // of the sum of four uniform numbers in [0, 1]
  return (sum / 65535.0F - 2.0F) / kDeviation;
}

struct PixelBox {
  int min_u = 0;
  int min_v = 0;
  int max_u = 0;
  int max_v = 0;
};

PixelBox BoxOf(const Mask& mask) {
  PixelBox box = {mask.width(), mask.height(), -1, -1};
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      if (mask(u, v) == 0) continue;
      box = {std::min(box.min_u, u), std::min(box.min_v, v), std::max(box.max_u, u), v};
    }
  }
  return box;
}

// The image ends within the object.
void Truncate(Random& random, const PixelBox& box, Raster& raster) {
  const float share = Draw(random, 0.05, 0.4);
  const int w = box.max_u - box.min_u + 1;
  const int h = box.max_v - box.min_v + 1;
  const std::uint64_t side = random.Index(5);  // the lower border cuts most often
  const int cut_w = static_cast<int>(share * static_cast<float>(w));
  const int cut_h = static_cast<int>(share * static_cast<float>(h));
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      const bool gone =
          (side == 0 && u < box.min_u + cut_w) || (side == 1 && u > box.max_u - cut_w) ||
          (side == 2 && v < box.min_v + cut_h / 2) || (side >= 3 && v > box.max_v - cut_h);
      if (gone) raster.mask(u, v) = 0;
    }
  }
}

// Something nearer stands before the object: all beyond a straight edge, or a box. With
// `taken_for_object` the segmentation keeps a part of it.
void Occlude(Random& random, const PixelBox& box, bool taken_for_object, Raster& raster) {
  const float w = static_cast<float>(box.max_u - box.min_u + 1);
  const float h = static_cast<float>(box.max_v - box.min_v + 1);
  const float middle_u = 0.5F * static_cast<float>(box.min_u + box.max_u);
  const float middle_v = 0.5F * static_cast<float>(box.min_v + box.max_v);
  const bool edge = Chance(random, 0.5);
  const float angle = Draw(random, 0, 2 * std::numbers::pi);
  const float nu = std::cos(angle);
  const float nv = std::sin(angle);
  const float reach = 0.5F * (std::abs(nu) * w + std::abs(nv) * h);
  const float beyond = reach * Draw(random, 0.2, 0.9);
  const float box_u = middle_u + w * Draw(random, -0.5, 0.5);
  const float box_v = middle_v + h * Draw(random, -0.5, 0.5);
  const float half_u = w * Draw(random, 0.04, 0.18);
  const float half_v = h * Draw(random, 0.04, 0.3);
  const float c = std::cos(0.3F * angle);
  const float s = std::sin(0.3F * angle);
  const Eigen::Vector3f paint(Draw(random, 0, 1), Draw(random, 0, 1), Draw(random, 0, 1));
  const float nearer_m = Draw(random, 0.02, 0.3);
  const float kept = taken_for_object ? Draw(random, 2, 0.12 * (w + h)) : 0.0F;
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      const float du = static_cast<float>(u) - middle_u;
      const float dv = static_cast<float>(v) - middle_v;
      const float over = edge ? nu * du + nv * dv - beyond : 0;
      const float bu = static_cast<float>(u) - box_u;
      const float bv = static_cast<float>(v) - box_v;
      const bool hidden =
          edge ? over > 0
               : std::abs(c * bu + s * bv) < half_u && std::abs(c * bv - s * bu) < half_v;
      if (!hidden) continue;
      const bool foreign = taken_for_object && (!edge || over < kept) &&
                           raster.true_depth_m(u, v) > 0 && raster.mask(u, v) != 0;
      if (foreign) {
        raster.colour(u, v) = paint * (0.8F + 0.2F * ValueNoise({bu * 0.2F, bv * 0.2F, angle}));
        raster.depth_m(u, v) = std::max(0.3F, raster.true_depth_m(u, v) - nearer_m);
      } else {
        raster.mask(u, v) = 0;
      }
    }
  }
}

// A table, a counter or the image's border leaves only a part of it: mostly what is above a line,
// the backs of chairs that are pushed in.
void HideMost(Random& random, const PixelBox& box, Raster& raster) {
  const double down = 0.5 * std::numbers::pi;
  const float angle = Chance(random, 0.7) ? Draw(random, down - 0.35, down + 0.35)
                                          : Draw(random, 0, 2 * std::numbers::pi);
  const float nu = std::cos(angle);
  const float nv = std::sin(angle);
  const float w = static_cast<float>(box.max_u - box.min_u + 1);
  const float h = static_cast<float>(box.max_v - box.min_v + 1);
  const float middle_u = 0.5F * static_cast<float>(box.min_u + box.max_u);
  const float middle_v = 0.5F * static_cast<float>(box.min_v + box.max_v);
  const float reach = 0.5F * (std::abs(nu) * w + std::abs(nv) * h);
  const float beyond = reach * Draw(random, -0.75, 0.2);
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      const float du = static_cast<float>(u) - middle_u;
      const float dv = static_cast<float>(v) - middle_v;
      if (nu * du + nv * dv > beyond) raster.mask(u, v) = 0;
    }
  }
}

float HeightAt(const Raster& raster, int u, int v) {
  const float z = raster.true_depth_m(u, v);
  return static_cast<float>(raster.ground_camera.SignedDistance(raster.camera.Unproject(u, v, z)));
}

// A table seen from close by, whose legs are hidden by chairs: what lies above some height, of
// which the image's borders cut some.
void KeepTop(Random& random, Raster& raster) {
  float highest_m = 0;
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      if (raster.mask(u, v) != 0) highest_m = std::max(highest_m, HeightAt(raster, u, v));
    }
  }
  const float least_m = highest_m * Draw(random, 0.5, 0.96);
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      if (raster.mask(u, v) != 0 && HeightAt(raster, u, v) < least_m) raster.mask(u, v) = 0;
    }
  }
  for (const double often : {0.7, 0.4}) {
    const PixelBox box = BoxOf(raster.mask);
    if (box.max_u >= 0 && Chance(random, often)) Truncate(random, box, raster);
  }
}

// What lies near the ground is taken for ground, with the limit that segmentation has
// (segment/segment_objects.h); now and then legs are lost to greater height.
void CutNearGround(Random& random, Raster& raster) {
  const float factor = Draw(random, 0.7, 1.5);
  const float lost_m = Chance(random, 0.2) ? Draw(random, 0.03, 0.25) : 0.0F;
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      if (raster.mask(u, v) == 0) continue;
      const float z = raster.true_depth_m(u, v);
      const double height_m = HeightAt(raster, u, v);
      const double limit_m = std::max(factor * (0.03F + 0.006F * z * z), lost_m);
      if (height_m < limit_m) raster.mask(u, v) = 0;
    }
  }
}

// No depth at grazing angles, in spots, and in the shadow beside near edges. A part of it is filled
// by the segmentation and stays in the mask.
void LoseDepth(Random& random, Raster& raster) {
  const float grazing = Draw(random, 0.05, 0.3);
  const float spots = Chance(random, 0.5) ? Draw(random, 0.72, 0.95) : 2.0F;
  const float frequency = Draw(random, 0.06, 0.3);
  const float phase = Draw(random, 0, 100);
  const bool stays = Chance(random, 0.5);
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      const render::RayHit& hit = raster.hits(u, v);
      if (raster.mask(u, v) == 0 || hit.instance < 0) continue;
      const bool lost =
          -hit.normal_world.dot(raster.rays(u, v)) < grazing * Draw(random, 0.3, 1.2) ||
          (spots < 1 && ValueNoise({static_cast<float>(u) * frequency,
                                    static_cast<float>(v) * frequency,
                                    phase}) > spots);
      if (!lost) continue;
      raster.depth_m(u, v) = 0;
      if (!stays) raster.mask(u, v) = 0;
    }
  }
}

void ShadowBesideEdges(Random& random, Raster& raster) {
  const int reach = static_cast<int>(random.Index(4));
  if (reach == 0) return;
  const bool left = Chance(random, 0.6);
  const DepthImage before = raster.true_depth_m;
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      const float z = before(u, v);
      if (z <= 0) continue;
      for (int step = 1; step <= reach; ++step) {
        const int other = left ? u + step : u - step;
        if (!before.Contains(other, v)) break;
        const float near = before(other, v);
        if (near > 0 && near < z - 0.08F) {
          raster.depth_m(u, v) = 0;
          raster.mask(u, v) = 0;
          break;
        }
      }
    }
  }
}

// Pixels with a one within `reach` along rows (or columns); beyond the border lies `border`.
Mask Spread(const Mask& from, int reach, bool along_rows, std::uint8_t border) {
  Mask to = from;
  const int w = from.width();
  const int h = from.height();
  for (int step = -reach; step <= reach; ++step) {
    const int du = along_rows ? step : 0;
    const int dv = along_rows ? 0 : step;
    for (int v = 0; v < h; ++v) {
      std::uint8_t* const out = to.row(v);
      const bool within = v + dv >= 0 && v + dv < h;
      const int first = within ? std::min(w, std::max(0, -du)) : w;
      const int last = std::max(first, std::min(w, w - du));
      for (int u = 0; u < first; ++u) out[u] |= border;
      for (int u = first; u < last; ++u) out[u] |= from(u + du, v + dv);
      for (int u = last; u < w; ++u) out[u] |= border;
    }
  }
  return to;
}

// Pixels with one that is `inside` the mask within `reach` along rows and columns. Beyond the
// border nothing is inside.
Mask Near(const Mask& mask, int reach, bool inside) {
  Mask wanted(mask.width(), mask.height());
  for (std::size_t n = 0; n < mask.size(); ++n)
    wanted.data()[n] = (mask.data()[n] != 0) == inside ? 1 : 0;
  const std::uint8_t border = inside ? 0 : 1;
  return Spread(Spread(wanted, reach, true, border), reach, false, border);
}

// The mask is too wide by a rim of background, or too narrow, in places.
void ShiftRim(Random& random, Raster& raster) {
  const std::uint64_t kind = random.Index(3);
  if (kind == 0) return;
  const bool wider = kind == 1;
  const int reach = 1 + static_cast<int>(random.Index(wider ? 3 : 2));
  const Eigen::Vector3f paint(Draw(random, 0.1, 1), Draw(random, 0.1, 1), Draw(random, 0.1, 1));
  const float phase = Draw(random, 0, 100);
  const float often = Draw(random, 0.25, 0.7);
  const Mask near = Near(raster.mask, reach, wider);
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      if (near(u, v) == 0 || (raster.mask(u, v) != 0) == wider) continue;
      if (ValueNoise(
              {static_cast<float>(u) * 0.08F + phase, static_cast<float>(v) * 0.08F, phase}) <
          often) {
        continue;
      }
      raster.mask(u, v) = wider ? 1 : 0;
      if (!wider) continue;
      raster.colour(u, v) = paint;
      raster.depth_m(u, v) = 0;
    }
  }
}

// Axial noise of a structured-light sensor, in part shared with the neighbours.
void AddDepthNoise(Random& random, Raster& raster) {
  const float gain = Draw(random, 0.5, 2.0);
  constexpr int kCell = 4;  // px over which noise is shared, as by a sensor's correlation window
  const int columns = raster.width() / kCell + 2;
  const int rows = raster.height() / kCell + 2;
  std::vector<float> coarse(static_cast<std::size_t>(columns * rows));
  for (float& value : coarse) value = QuickNormal(random);
  const auto at = [&](int a, int b) { return coarse[static_cast<std::size_t>(b * columns + a)]; };
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      float& z = raster.depth_m(u, v);
      if (z <= 0) continue;
      const float a = static_cast<float>(u % kCell) / kCell;
      const float b = static_cast<float>(v % kCell) / kCell;
      const int i = u / kCell;
      const int j = v / kCell;
      const float shared = (1 - b) * ((1 - a) * at(i, j) + a * at(i + 1, j)) +
                           b * ((1 - a) * at(i, j + 1) + a * at(i + 1, j + 1));
      const float deviation_m = 0.0012F + 0.0019F * (z - 0.4F) * (z - 0.4F);
      z += gain * deviation_m * (1.1F * shared + 0.5F * QuickNormal(random));
      z = std::max(z, 0.2F);
    }
  }
}

// Along rows, then along columns; pixels outside the mask do not take part.
void BlurColour(float sigma_px, Raster& raster) {
  constexpr int kBlurReach_px = 2;  // px; at a deviation of 1.2 px the next would weigh 4 %
  const std::array weights = {
      1.0F, std::exp(-0.5F / (sigma_px * sigma_px)), std::exp(-2.0F / (sigma_px * sigma_px))};
  // Colour and one, or four zeros outside the mask; with a rim of zeros.
  Image<Eigen::Vector4f> before(raster.width() + 2 * kBlurReach_px,
                                raster.height() + 2 * kBlurReach_px,
                                Eigen::Vector4f::Zero());
  for (const bool along_rows : {true, false}) {
    for (int v = 0; v < raster.height(); ++v) {
      for (int u = 0; u < raster.width(); ++u) {
        if (raster.mask(u, v) == 0) continue;
        before(u + kBlurReach_px, v + kBlurReach_px) << raster.colour(u, v), 1.0F;
      }
    }
    const std::ptrdiff_t next = along_rows ? 1 : before.width();
    for (int v = 0; v < raster.height(); ++v) {
      for (int u = 0; u < raster.width(); ++u) {
        if (raster.mask(u, v) == 0) continue;
        const Eigen::Vector4f* const at = &before(u + kBlurReach_px, v + kBlurReach_px);
        const Eigen::Vector4f sum = at[0] + weights[2] * at[-2 * next] + weights[1] * at[-next] +
                                    weights[1] * at[next] + weights[2] * at[2 * next];
        raster.colour(u, v) = sum.head<3>() / sum.w();
      }
    }
  }
}

void AddColourNoise(Random& random, Raster& raster) {
  const float deviation = Draw(random, 0, 0.03);
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      if (raster.mask(u, v) == 0) continue;
      Eigen::Vector3f& colour = raster.colour(u, v);
      for (int c = 0; c < 3; ++c)
        colour[c] = std::clamp(colour[c] + deviation * QuickNormal(random), 0.0F, 1.0F);
    }
  }
}

}  // namespace

void KeepView(Raster& raster) {
  raster.depth_m = raster.true_depth_m;
  raster.mask = Mask(raster.width(), raster.height());
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u)
      raster.mask(u, v) = raster.true_depth_m(u, v) > 0 ? 1 : 0;
  }
}

DEEPSLAM_WIDE_VECTORS
void SpoilView(Random& random, Left left, Raster& raster) {
  KeepView(raster);
  const PixelBox box = BoxOf(raster.mask);
  if (box.max_u < 0) return;
  if (Chance(random, 0.3)) Truncate(random, box, raster);
  if (Chance(random, 0.35)) Occlude(random, box, Chance(random, 0.3), raster);
  if (Chance(random, 0.12)) Occlude(random, box, false, raster);
  if (left == Left::kPart) HideMost(random, box, raster);
  if (left == Left::kTop) KeepTop(random, raster);
  if (Chance(random, 0.85)) CutNearGround(random, raster);
  if (Chance(random, 0.7)) LoseDepth(random, raster);
  if (Chance(random, 0.6)) ShadowBesideEdges(random, raster);
  ShiftRim(random, raster);
  AddDepthNoise(random, raster);
  const float sigma_px = Draw(random, 0, 1.2);
  if (sigma_px > 0.3F) BlurColour(sigma_px, raster);
  AddColourNoise(random, raster);
}

}  // namespace deepslam::priors
