#include "deepslam/propose/network_crop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/upright.h"

namespace deepslam::propose {
namespace {

constexpr double kMargin = 1.1;
constexpr int kFewestPixels = 40;
constexpr double kLowestHeight_m = -0.1;
constexpr double kHeightStep_m = 0.01;

struct MaskBox {
  int min_u = 0;
  int min_v = 0;
  int max_u = -1;
  int max_v = -1;
  int count = 0;
};

MaskBox BoxOf(const Mask& mask) {
  MaskBox box = {mask.width(), mask.height(), -1, -1, 0};
  for (int v = 0; v < mask.height(); ++v) {
    const std::uint8_t* const row = mask.row(v);
    for (int u = 0; u < mask.width(); ++u) {
      if (row[u] == 0) continue;
      ++box.count;
      box.min_u = std::min(box.min_u, u);
      box.max_u = std::max(box.max_u, u);
      box.min_v = std::min(box.min_v, v);
      box.max_v = v;
    }
  }
  return box;
}

double MedianDepth(const ObjectView& view) {
  std::vector<float> depths;
  const auto* mask = view.mask_crop.data();
  const float* depth_m = view.depth_crop_m.data();
  for (std::size_t n = 0; n < view.depth_crop_m.size(); ++n) {
    if (mask[n] != 0 && depth_m[n] > 0) depths.push_back(depth_m[n]);
  }
  if (depths.empty()) return 0;
  return Median(depths);
}

// Red, green, blue (0 to 255) and silhouette (0 or 1) of the box's pixels and a rim around them;
// all 0 where there is no silhouette.
class Cutout {
 public:
  Cutout(const ObjectView& view, const MaskBox& box)
      : u0_(box.min_u - 1),
        v0_(box.min_v - 1),
        values_(box.max_u - u0_ + 3, box.max_v - v0_ + 3, Eigen::Vector4f::Zero()) {
    for (int v = box.min_v; v <= box.max_v; ++v) {
      for (int u = box.min_u; u <= box.max_u; ++u) {
        if (view.mask_crop(u, v) == 0) continue;
        const Rgb8& colour = view.colour_crop(u, v);
        values_(u - u0_, v - v0_) = {static_cast<float>(colour.r),
                                     static_cast<float>(colour.g),
                                     static_cast<float>(colour.b),
                                     1.0F};
      }
    }
  }
  // Any pixel.
  [[nodiscard]] Eigen::Vector4f At(int u, int v) const {
    return values_(std::clamp(u - u0_, 0, values_.width() - 1),
                   std::clamp(v - v0_, 0, values_.height() - 1));
  }

 private:
  int u0_;
  int v0_;
  Image<Eigen::Vector4f> values_;
};

// Where the samples of the square lie along one of its sides: between the pixel `at` and the next,
// `next` of the way.
struct Between {
  int at = 0;
  float next = 0;
};

std::vector<Between> SamplesAlong(double first, double step, int samples) {
  std::vector<Between> along;
  along.reserve(static_cast<std::size_t>(kCropSide * samples));
  for (int x = 0; x < kCropSide; ++x) {
    for (int a = 0; a < samples; ++a) {
      const double u = first + (x + (a + 0.5) / samples) * step - 0.5;
      const double whole = std::floor(u);
      along.push_back({static_cast<int>(whole), static_cast<float>(u - whole)});
    }
  }
  return along;
}

void AddBetween(
    const Cutout& cutout, const Between& u, const Between& v, float weight, Eigen::Vector4f& sum) {
  sum += weight * (1 - u.next) * (1 - v.next) * cutout.At(u.at, v.at);
  sum += weight * u.next * (1 - v.next) * cutout.At(u.at + 1, v.at);
  sum += weight * (1 - u.next) * v.next * cutout.At(u.at, v.at + 1);
  sum += weight * u.next * v.next * cutout.At(u.at + 1, v.at + 1);
}

// Not negative.
std::uint8_t OnWhite(float colour, float share) {
  return static_cast<std::uint8_t>(std::min(255.0F, colour + (1 - share) * 255.0F) + 0.5F);
}

// The square is white from the start, and stays so where none of its samples is near the box.
DEEPSLAM_WIDE_VECTORS
void FillColour(const ObjectView& view, const MaskBox& box, NetworkCrop& crop) {
  const double step = crop.side_px / kCropSide;
  constexpr int kMostSamples = 4;
  // Values between pixels need no second sample before a step leaves pixels out.
  const int samples = std::clamp(static_cast<int>(std::lround(step)), 1, kMostSamples);
  const float weight = 1.0F / static_cast<float>(samples * samples);
  const std::vector<Between> columns = SamplesAlong(crop.u0, step, samples);
  const std::vector<Between> rows = SamplesAlong(crop.v0, step, samples);
  const Cutout cutout(view, box);
  const auto of_pixel = [samples](const std::vector<Between>& along, int x) {
    return std::span(along).subspan(static_cast<std::size_t>(x * samples),
                                    static_cast<std::size_t>(samples));
  };
  for (int y = 0; y < kCropSide; ++y) {
    const std::span<const Between> down = of_pixel(rows, y);
    if (down.back().at + 1 < box.min_v || down.front().at > box.max_v) continue;
    for (int x = 0; x < kCropSide; ++x) {
      const std::span<const Between> across = of_pixel(columns, x);
      if (across.back().at + 1 < box.min_u || across.front().at > box.max_u) continue;
      Eigen::Vector4f mixed = Eigen::Vector4f::Zero();
      for (const Between& v : down) {
        for (const Between& u : across) AddBetween(cutout, u, v, weight, mixed);
      }
      const float share = mixed.w();
      if (share == 0) continue;
      crop.colour(x, y) = {
          OnWhite(mixed.x(), share), OnWhite(mixed.y(), share), OnWhite(mixed.z(), share)};
      crop.silhouette(x, y) = static_cast<std::uint8_t>(255.0F * std::min(1.0F, share) + 0.5F);
    }
  }
}

// Rounded to the nearest of 0, ..., 255.
std::uint8_t ToByte(double value, double lowest) {
  return static_cast<std::uint8_t>(std::clamp(value, lowest, 255.0) + 0.5);
}

DEEPSLAM_WIDE_VECTORS
void FillDepth(const ObjectView& view, NetworkCrop& crop) {
  const double step = crop.side_px / kCropSide;
  const auto pixel = [step](double first, int n) {
    return static_cast<int>(std::floor(first + (n + 0.5) * step));
  };
  std::array<int, kCropSide> columns{};
  for (int x = 0; x < kCropSide; ++x) columns[static_cast<std::size_t>(x)] = pixel(crop.u0, x);
  for (int y = 0; y < kCropSide; ++y) {
    const int v = pixel(crop.v0, y);
    for (int x = 0; x < kCropSide; ++x) {
      const int u = columns[static_cast<std::size_t>(x)];
      if (!view.mask_crop.Contains(u, v) || view.mask_crop(u, v) == 0) continue;
      const double z = view.depth_crop_m(u, v);
      if (!(z > 0)) continue;
      crop.depth(x, y) = ToByte(128 + 127 * (z - crop.reference_m) / crop.side_m, 1);
      if (!view.ground_camera) continue;
      const double height_m = view.ground_camera->SignedDistance(view.camera.Unproject(u, v, z));
      crop.height(x, y) = ToByte((height_m - kLowestHeight_m) / kHeightStep_m, 0);
    }
  }
}

QuarterTurn UprightTurnOf(const ObjectView& view) {
  if (!view.ground_camera) return QuarterTurn::kNone;
  return UprightTurn(view.ground_camera->normal).value_or(QuarterTurn::kNone);
}

// Pictures, camera and ground; the crop's place in its frame is given up.
ObjectView TurnedView(const ObjectView& view, QuarterTurn turn) {
  ObjectView turned;
  turned.colour_crop = Turned(view.colour_crop, turn);
  turned.depth_crop_m = Turned(view.depth_crop_m, turn);
  turned.mask_crop = Turned(view.mask_crop, turn);
  turned.camera = Turned(view.camera, turn);
  turned.ground_camera = Turned(*view.ground_camera, turn);
  return turned;
}

Result<NetworkCrop> CropUpright(const ObjectView& view, bool use_depth) {
  const Mask& mask = view.mask_crop;
  const MaskBox box = BoxOf(mask);
  if (box.count < kFewestPixels) {
    return InvalidInput("the silhouette has " + std::to_string(box.count) +
                        " pixels; a network needs " + std::to_string(kFewestPixels));
  }
  NetworkCrop crop;
  crop.colour = ColourImage(kCropSide, kCropSide, {255, 255, 255});
  crop.silhouette = Image<std::uint8_t>(kCropSide, kCropSide);
  crop.depth = crop.silhouette;
  crop.height = crop.silhouette;
  crop.side_px = kMargin * std::max(box.max_u - box.min_u + 1, box.max_v - box.min_v + 1);
  crop.u0 = 0.5 * (box.min_u + box.max_u + 1) - 0.5 * crop.side_px;
  crop.v0 = 0.5 * (box.min_v + box.max_v + 1) - 0.5 * crop.side_px;
  FillColour(view, box, crop);
  const double focal_px = 0.5 * (view.camera.fx + view.camera.fy);
  if (focal_px > 0) crop.spread = crop.side_px / focal_px;
  if (!use_depth) return crop;
  crop.reference_m = MedianDepth(view);
  if (!(crop.reference_m > 0) || !(focal_px > 0)) return crop;
  crop.side_m = crop.spread * crop.reference_m;
  FillDepth(view, crop);
  return crop;
}

}  // namespace

Result<NetworkCrop> MakeNetworkCrop(const ObjectView& view, bool use_depth) {
  const Mask& mask = view.mask_crop;
  if (view.colour_crop.width() != mask.width() || view.colour_crop.height() != mask.height() ||
      view.depth_crop_m.width() != mask.width() || view.depth_crop_m.height() != mask.height()) {
    return InvalidInput("colour, depth and silhouette of the view differ in size");
  }
  const QuarterTurn upright = UprightTurnOf(view);
  if (upright == QuarterTurn::kNone) return CropUpright(view, use_depth);
  return CropUpright(TurnedView(view, upright), use_depth);
}

void FillPlanes(const NetworkCrop& crop, std::span<float> values) {
  DEEPSLAM_CHECK(values.size() == kCropValues, "a crop has kCropValues values");
  constexpr std::size_t kPixels = static_cast<std::size_t>(kCropSide) * kCropSide;
  for (std::size_t n = 0; n < kPixels; ++n) {
    const Rgb8& colour = crop.colour.data()[n];
    values[n] = static_cast<float>(colour.r) / 255.0F;
    values[kPixels + n] = static_cast<float>(colour.g) / 255.0F;
    values[2 * kPixels + n] = static_cast<float>(colour.b) / 255.0F;
    values[3 * kPixels + n] = static_cast<float>(crop.silhouette.data()[n]) / 255.0F;
    const std::uint8_t depth = crop.depth.data()[n];
    const bool known = depth != 0;
    values[4 * kPixels + n] = known ? (static_cast<float>(depth) - 128.0F) / 127.0F : 0.0F;
    values[5 * kPixels + n] =
        known ? static_cast<float>(crop.height.data()[n]) * 0.01F - 0.1F : 0.0F;
    values[6 * kPixels + n] = known ? 1.0F : 0.0F;
  }
}

}  // namespace deepslam::propose
