#include "deepslam/propose/network_crop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::propose {
namespace {

constexpr int kFewestPixels = 40;         // of a silhouette; fewer show no shape
constexpr double kLowestHeight_m = -0.1;  // of value 0: noise puts points of the floor below it
constexpr double kHeightStep_m = 0.01;    // a byte then reaches up to 2.45 m

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

double MedianDepth(const ObjectView& view, const MaskBox& box, const CropCamera& camera) {
  std::vector<float> depths;
  depths.reserve(static_cast<std::size_t>(box.count));
  for (int v = box.min_v; v <= box.max_v; ++v) {
    for (int u = box.min_u; u <= box.max_u; ++u) {
      if (view.mask_crop(u, v) == 0 || !(view.depth_crop_m(u, v) > 0)) continue;
      const Eigen::Vector3d point = view.camera.Unproject(u, v, view.depth_crop_m(u, v));
      depths.push_back(static_cast<float>(camera.DepthOf(point)));
    }
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
  // Between four pixels, for less than a pixel outside the box.
  [[nodiscard]] Eigen::Vector4f Between(float u, float v) const {
    const float whole_u = std::floor(u);
    const float whole_v = std::floor(v);
    const float right = u - whole_u;
    const float below = v - whole_v;
    const Eigen::Vector4f* const upper =
        values_.row(static_cast<int>(whole_v) - v0_) + (static_cast<int>(whole_u) - u0_);
    const Eigen::Vector4f* const lower = upper + values_.width();
    return (1 - below) * ((1 - right) * upper[0] + right * upper[1]) +
           below * ((1 - right) * lower[0] + right * lower[1]);
  }

 private:
  int u0_;
  int v0_;
  Image<Eigen::Vector4f> values_;
};

// Pixels of the view at places of the square.
class PixelsOfSquare {
 public:
  PixelsOfSquare(const CropCamera& crop, const PinholeCamera& camera) {
    Eigen::Matrix3d pixel_from_ray;
    pixel_from_ray << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
    Eigen::Matrix3d ray_from_place;
    ray_from_place << crop.side, 0, crop.left, 0, crop.side, crop.top, 0, 0, 1;
    pixel_from_place_ = (pixel_from_ray * crop.view_from_crop * ray_from_place).cast<float>();
  }
  // Of row `y` of `count` by `count` places; far outside for what is behind the view's camera.
  void FillRow(int y, int count, std::vector<float>& u, std::vector<float>& v) const {
    u.resize(static_cast<std::size_t>(count));
    v.resize(static_cast<std::size_t>(count));
    FillRow(y, count, u.data(), v.data());
  }

 private:
  DEEPSLAM_WIDE_VECTORS
  void FillRow(int y, int count, float* u, float* v) const {
    const float step = 1.0F / static_cast<float>(count);
    const Eigen::Vector3f along = pixel_from_place_.col(0) * step;
    const Eigen::Vector3f first =
        0.5F * along + pixel_from_place_.col(1) * ((static_cast<float>(y) + 0.5F) * step) +
        pixel_from_place_.col(2);
    // Keeps the division finite where a ray of the square runs behind the camera.
    constexpr float kNearest = 1e-3F;
    for (int n = 0; n < count; ++n) {
      const auto x = static_cast<float>(n);
      const float scale = 1 / std::max(kNearest, first.z() + x * along.z());
      u[n] = (first.x() + x * along.x()) * scale;
      v[n] = (first.y() + x * along.y()) * scale;
    }
  }

  Eigen::Matrix3f pixel_from_place_;
};

// Not negative.
std::uint8_t OnWhite(float colour, float share) {
  return static_cast<std::uint8_t>(std::min(255.0F, colour + (1 - share) * 255.0F) + 0.5F);
}

// The square is white from the start, and stays so where none of its samples is near the box.
DEEPSLAM_WIDE_VECTORS
void FillColour(const ObjectView& view,
                const MaskBox& box,
                const PixelsOfSquare& pixels,
                NetworkCrop& crop) {
  const auto step =
      static_cast<float>(crop.camera.side * std::max(view.camera.fx, view.camera.fy) / kCropSide);
  constexpr int kMostSamples = 4;  // a side of a pixel: bounds the time of close-ups
  // Values between pixels need no second sample before a step leaves pixels out.
  const int samples = std::clamp(static_cast<int>(std::lround(step)), 1, kMostSamples);
  const float weight = 1.0F / static_cast<float>(samples * samples);
  const auto left = static_cast<float>(box.min_u - 1);
  const auto top = static_cast<float>(box.min_v - 1);
  const auto right = static_cast<float>(box.max_u + 1);
  const auto bottom = static_cast<float>(box.max_v + 1);
  const Cutout cutout(view, box);
  std::vector<float> u;
  std::vector<float> v;
  std::array<Eigen::Vector4f, kCropSide> mixed;
  for (int y = 0; y < kCropSide; ++y) {
    mixed.fill(Eigen::Vector4f::Zero());
    for (int b = 0; b < samples; ++b) {
      pixels.FillRow(y * samples + b, kCropSide * samples, u, v);
      for (std::size_t n = 0; n < u.size(); ++n) {
        if (!(u[n] > left && u[n] < right && v[n] > top && v[n] < bottom)) continue;
        mixed[n / static_cast<std::size_t>(samples)] += weight * cutout.Between(u[n], v[n]);
      }
    }
    for (int x = 0; x < kCropSide; ++x) {
      const Eigen::Vector4f& pixel = mixed[static_cast<std::size_t>(x)];
      const float share = pixel.w();
      if (share == 0) continue;
      crop.colour(x, y) = {
          OnWhite(pixel.x(), share), OnWhite(pixel.y(), share), OnWhite(pixel.z(), share)};
      crop.silhouette(x, y) = static_cast<std::uint8_t>(255.0F * std::min(1.0F, share) + 0.5F);
    }
  }
}

// Rounded to the nearest of 0, ..., 255.
std::uint8_t ToByte(double value, double lowest) {
  return static_cast<std::uint8_t>(std::clamp(value, lowest, 255.0) + 0.5);
}

DEEPSLAM_WIDE_VECTORS
void FillDepth(const ObjectView& view,
               const MaskBox& box,
               const PixelsOfSquare& pixels,
               NetworkCrop& crop) {
  std::vector<float> row_u;
  std::vector<float> row_v;
  for (int y = 0; y < kCropSide; ++y) {
    pixels.FillRow(y, kCropSide, row_u, row_v);
    for (int x = 0; x < kCropSide; ++x) {
      const auto u = static_cast<int>(std::floor(row_u[static_cast<std::size_t>(x)] + 0.5F));
      const auto v = static_cast<int>(std::floor(row_v[static_cast<std::size_t>(x)] + 0.5F));
      if (u < box.min_u || u > box.max_u || v < box.min_v || v > box.max_v) continue;
      const double z = view.depth_crop_m(u, v);
      if (view.mask_crop(u, v) == 0 || !(z > 0)) continue;
      const Eigen::Vector3d point = view.camera.Unproject(u, v, z);
      const double beyond_m = crop.camera.DepthOf(point) - crop.reference_m;
      crop.depth(x, y) = ToByte(128 + 127 * beyond_m / crop.side_m, 1);
      if (!view.ground_camera) continue;
      const double height_m = view.ground_camera->SignedDistance(point);
      crop.height(x, y) = ToByte((height_m - kLowestHeight_m) / kHeightStep_m, 0);
    }
  }
}

}  // namespace

Result<NetworkCrop> MakeNetworkCrop(const ObjectView& view, bool use_depth) {
  const Mask& mask = view.mask_crop;
  if (view.colour_crop.width() != mask.width() || view.colour_crop.height() != mask.height() ||
      view.depth_crop_m.width() != mask.width() || view.depth_crop_m.height() != mask.height()) {
    return InvalidInput("colour, depth and silhouette of the view differ in size");
  }
  if (!(view.camera.fx > 0) || !(view.camera.fy > 0))
    return InvalidInput("the view's camera has no focal length");
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
  crop.camera = *AimAt(mask, view.camera, view.ground_camera, view.upright);
  const PixelsOfSquare pixels(crop.camera, view.camera);
  FillColour(view, box, pixels, crop);
  if (!use_depth) return crop;
  crop.elevation_rad = ElevationOf(crop.camera, view.ground_camera);
  crop.reference_m = MedianDepth(view, box, crop.camera);
  if (!(crop.reference_m > 0)) return crop;
  crop.side_m = crop.camera.side * crop.reference_m;
  FillDepth(view, box, pixels, crop);
  return crop;
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
