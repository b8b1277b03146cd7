#include "deepslam/shape/view_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>

namespace deepslam::shape {
namespace {

constexpr float kMaxDepth_m = 20.0F;  // no RGB-D camera of rooms measures further
constexpr double kPatchRadius_m =
    0.02;  // normals: wide against depth noise, small against furniture edges
constexpr int kMinPatchRadius_px = 2;
constexpr int kMaxPatchRadius_px = 6;

bool IsUsable(float depth_m) { return depth_m > 0 && depth_m < kMaxDepth_m; }

// Depth difference between pixels `steps` apart that a real surface can have: 1 cm of noise, and
// slopes up to 80 degrees against the image plane.
float JumpLimit(const PinholeCamera& camera, float depth_m, int steps) {
  constexpr float kSteepest = 5.7F;  // tan 80 deg
  return 0.01F + kSteepest * depth_m * static_cast<float>(steps) / static_cast<float>(camera.fx);
}

// A pixel whose neighbours mostly agree with it: no edge, no flying pixel.
bool IsCoherent(const ObjectView& view, int u, int v) {
  const DepthImage& depth_m = view.depth_crop_m;
  constexpr int kMinAgreeing = 6;
  const float center = depth_m(u, v);
  const float limit = JumpLimit(view.camera, center, 1);
  int agreeing = -1;  // the pixel itself agrees
  for (int y = std::max(0, v - 1); y <= std::min(depth_m.height() - 1, v + 1); ++y) {
    for (int x = std::max(0, u - 1); x <= std::min(depth_m.width() - 1, u + 1); ++x) {
      const float other = depth_m(x, y);
      agreeing += IsUsable(other) && std::abs(other - center) <= limit ? 1 : 0;
    }
  }
  return agreeing >= kMinAgreeing;
}

std::optional<Eigen::Vector3f> PatchNormal(const ObjectView& view, int u, int v) {
  const DepthImage& depth_m = view.depth_crop_m;
  const float center_m = depth_m(u, v);
  const Eigen::Vector3d center = view.camera.Unproject(u, v, center_m);
  const int radius =
      std::clamp(static_cast<int>(std::lround(kPatchRadius_m * view.camera.fx / center_m)),
                 kMinPatchRadius_px,
                 kMaxPatchRadius_px);
  std::array<float, kMaxPatchRadius_px + 1> limits;
  for (int steps = 0; steps <= radius; ++steps)
    limits[static_cast<std::size_t>(steps)] = JumpLimit(view.camera, center_m, steps);
  const int left = std::max(-radius, -u), right = std::min(radius, depth_m.width() - 1 - u);
  const int top = std::max(-radius, -v), bottom = std::min(radius, depth_m.height() - 1 - v);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  int count = 0;
  for (int dv = top; dv <= bottom; ++dv) {
    for (int du = left; du <= right; ++du) {
      const float other = depth_m(u + du, v + dv);
      const int steps = std::max(std::abs(du), std::abs(dv));
      if (!IsUsable(other) || std::abs(other - center_m) > limits[static_cast<std::size_t>(steps)])
        continue;
      const Eigen::Vector3d offset = view.camera.Unproject(u + du, v + dv, other) - center;
      sum += offset;
      squares += offset * offset.transpose();
      ++count;
    }
  }
  constexpr int kMinPatch = 8;
  if (count < kMinPatch) return std::nullopt;
  const Eigen::Matrix3d covariance = squares / count - sum * sum.transpose() / (count * count);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  // Neither a line of pixels nor a corner has a normal.
  const Eigen::Vector3d spread = solver.eigenvalues();
  if (!(spread[1] > 0) || spread[0] > 0.5 * spread[1]) return std::nullopt;
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  return (normal.dot(center) > 0 ? -normal : normal).cast<float>();
}

struct Pixel {
  std::int16_t u = 0;
  std::int16_t v = 0;
  Eigen::Vector3f point;
};

std::vector<Pixel> CoherentPixels(const ObjectView& view) {
  std::vector<Pixel> pixels;
  for (int v = 0; v < view.mask_crop.height(); ++v) {
    for (int u = 0; u < view.mask_crop.width(); ++u) {
      if (view.mask_crop(u, v) == 0 || !IsUsable(view.depth_crop_m(u, v))) continue;
      if (!IsCoherent(view, u, v)) continue;
      pixels.push_back({static_cast<std::int16_t>(u),
                        static_cast<std::int16_t>(v),
                        view.camera.Unproject(u, v, view.depth_crop_m(u, v)).cast<float>()});
    }
  }
  return pixels;
}

// Cells of a cubic raster, numbered in the order in which they are met.
class CellNumbers {
 public:
  explicit CellNumbers(std::size_t max_cells)
      : slots_(std::bit_ceil(2 * max_cells + 1), kFree), keys_(slots_.size()) {}

  std::uint32_t NumberOf(std::uint64_t key) {
    const std::size_t last = slots_.size() - 1;
    std::size_t at = (key * 0x9E3779B97F4A7C15ULL >> 32U) & last;
    while (slots_[at] != kFree && keys_[at] != key) at = (at + 1) & last;
    if (slots_[at] == kFree) {
      slots_[at] = count_++;
      keys_[at] = key;
    }
    return slots_[at];
  }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  static constexpr std::uint32_t kFree = 0xFFFFFFFFU;
  std::vector<std::uint32_t> slots_;
  std::vector<std::uint64_t> keys_;
  std::uint32_t count_ = 0;
};

// One pixel per cell of a cubic raster, the middle one in scan order.
std::vector<std::size_t> OnePerCell(const std::vector<Pixel>& pixels, float cell_m) {
  CellNumbers numbers(pixels.size());
  std::vector<std::uint32_t> cell_of(pixels.size());
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<std::int64_t>(std::floor(pixels[n].point[axis] / cell_m));
      key = (key << 21U) | (static_cast<std::uint64_t>(cell) & 0x1FFFFFU);
    }
    cell_of[n] = numbers.NumberOf(key);
  }
  std::vector<std::uint32_t> until_middle(numbers.count(), 0);
  for (const std::uint32_t cell : cell_of) ++until_middle[cell];
  for (std::uint32_t& count : until_middle) count = count / 2 + 1;
  std::vector<std::size_t> chosen;
  chosen.reserve(numbers.count());
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    if (--until_middle[cell_of[n]] == 0) chosen.push_back(n);
  }
  return chosen;
}

std::vector<std::size_t> Thinned(const ObjectView& view,
                                 const std::vector<Pixel>& pixels,
                                 std::size_t max_points) {
  std::vector<std::size_t> chosen(pixels.size());
  for (std::size_t n = 0; n < chosen.size(); ++n) chosen[n] = n;
  if (chosen.size() <= max_points) return chosen;
  double area_m2 = 0;
  for (const Pixel& pixel : pixels) {
    area_m2 += pixel.point.z() * pixel.point.z() / (view.camera.fx * view.camera.fy);
  }
  constexpr float kCoarser = 1.15F;
  auto cell_m = static_cast<float>(std::sqrt(area_m2 / static_cast<double>(max_points)));
  cell_m = std::max(cell_m, 1e-4F);
  // Cells around the origin never merge, so a tiny `max_points` needs the cut below.
  while (chosen.size() > max_points && cell_m < kMaxDepth_m) {
    chosen = OnePerCell(pixels, cell_m);
    cell_m *= kCoarser;
  }
  chosen.resize(std::min(chosen.size(), max_points));
  return chosen;
}

}  // namespace

ViewPoints ExtractViewPoints(const ObjectView& view, int max_points) {
  ViewPoints result;
  const bool same_size = view.mask_crop.width() == view.depth_crop_m.width() &&
                         view.mask_crop.height() == view.depth_crop_m.height();
  const bool has_camera = view.camera.fx > 0 && view.camera.fy > 0;
  if (!same_size || !has_camera || max_points <= 0) return result;
  if (view.mask_crop.width() > INT16_MAX || view.mask_crop.height() > INT16_MAX) return result;
  const std::vector<Pixel> pixels = CoherentPixels(view);
  for (const std::size_t n : Thinned(view, pixels, static_cast<std::size_t>(max_points))) {
    const std::optional<Eigen::Vector3f> normal = PatchNormal(view, pixels[n].u, pixels[n].v);
    if (!normal) continue;
    result.points_camera.push_back(pixels[n].point);
    result.normals_camera.push_back(*normal);
  }
  return result;
}

}  // namespace deepslam::shape
