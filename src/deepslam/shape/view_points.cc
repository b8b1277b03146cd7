#include "deepslam/shape/view_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>

#include "deepslam/core/wide_vectors.h"

namespace deepslam::shape {
namespace {

constexpr float kMaxDepth_m = 20.0F;  // no RGB-D camera of rooms measures further
constexpr double kPatchRadius_m =
    0.02;  // normals: wide against depth noise, small against furniture edges
constexpr int kMinPatchRadius_px = 2;
constexpr int kMaxPatchRadius_px = 6;

bool IsUsable(float depth_m) { return depth_m > 0 && depth_m < kMaxDepth_m; }

// Depth difference between neighbouring pixels that a real surface can have, per metre of depth and
// pixel between them, and beyond that: slopes up to 80 degrees against the image plane, and 1 cm of
// noise.
float SteepestPerPixel(const PinholeCamera& camera) {
  constexpr float kSteepest = 5.7F;  // tan 80 deg
  return kSteepest / static_cast<float>(camera.fx);
}
constexpr float kNoise_m = 0.01F;

// The depth of a view with so much of nothing around it that no patch leaves the image, unusable
// depth being 0.
class PaddedDepth {
 public:
  static constexpr int kRows = kMaxPatchRadius_px;
  static constexpr int kColumns = 16;

  explicit PaddedDepth(const DepthImage& depth_m)
      : padded_m_(depth_m.width() + 2 * kColumns, depth_m.height() + 2 * kRows, 0.0F) {
    for (int v = 0; v < depth_m.height(); ++v) {
      std::transform(depth_m.row(v),
                     depth_m.row(v) + depth_m.width(),
                     padded_m_.row(v + kRows) + kColumns,
                     [](float depth) { return IsUsable(depth) ? depth : 0.0F; });
    }
  }

  // Of the image: pixel 0 of the row, with kColumns before it and behind its last.
  [[nodiscard]] const float* Row(int v) const { return padded_m_.row(v + kRows) + kColumns; }
  [[nodiscard]] int width() const { return padded_m_.width() - 2 * kColumns; }
  [[nodiscard]] int height() const { return padded_m_.height() - 2 * kRows; }

 private:
  DepthImage padded_m_;
};

// Which pixels of a row have neighbours that mostly agree with them: no edges, no flying pixels.
DEEPSLAM_WIDE_VECTORS void FindCoherent(const PaddedDepth& depth_m,
                                        float steepest,
                                        int v,
                                        std::vector<std::int32_t>& is_coherent) {
  constexpr std::int32_t kMinAgreeing = 6;
  const float* const above = depth_m.Row(v - 1);
  const float* const row = depth_m.Row(v);
  const float* const below = depth_m.Row(v + 1);
  std::int32_t* const coherent = is_coherent.data();
  const int width = depth_m.width();
  for (int u = 0; u < width; ++u) {
    const float center = row[u];
    const float limit = kNoise_m + steepest * center;
    const auto agrees = [&](float other) -> std::int32_t {
      return (other > 0) & (std::abs(other - center) <= limit);
    };
    const std::int32_t agreeing = agrees(above[u - 1]) + agrees(above[u]) + agrees(above[u + 1]) +
                                  agrees(row[u - 1]) + agrees(row[u + 1]) + agrees(below[u - 1]) +
                                  agrees(below[u]) + agrees(below[u + 1]);
    coherent[u] = (center > 0) & (agreeing >= kMinAgreeing);
  }
}

// Sums over the pixels of a patch that belong to its middle's surface, of their offsets from it.
struct PatchSums {
  int count = 0;
  Eigen::Vector3d sum;
  Eigen::Matrix3d squares;
};

// Offsets are taken from differences of depth and pixels, which single precision holds well.
DEEPSLAM_WIDE_VECTORS PatchSums
SumPatch(const PaddedDepth& depth_m, const PinholeCamera& camera, int radius, int u, int v) {
  constexpr int kLanes = 16;  // columns, from `radius` before the middle on
  static_assert(kLanes > 2 * kMaxPatchRadius_px && kLanes <= PaddedDepth::kColumns);
  const float center = depth_m.Row(v)[u];
  const float steepest = SteepestPerPixel(camera) * center;
  const auto ray_u = static_cast<float>(u - camera.cx);
  const auto ray_v = static_cast<float>(v - camera.cy);
  const auto per_fx = static_cast<float>(1.0 / camera.fx);
  const auto per_fy = static_cast<float>(1.0 / camera.fy);
  std::array<float, kLanes> du;
  std::array<float, kLanes> noise;  // nothing agrees beyond the patch
  for (int n = 0; n < kLanes; ++n) {
    du[static_cast<std::size_t>(n)] = static_cast<float>(n - radius);
    noise[static_cast<std::size_t>(n)] =
        n > 2 * radius ? -std::numeric_limits<float>::infinity() : kNoise_m;
  }
  std::array<std::array<float, kLanes>, 10> sums{};
  for (int dv = -radius; dv <= radius; ++dv) {
    const float* const row = depth_m.Row(v + dv) + u - radius;
    const auto down = static_cast<float>(dv);
    const float down_steps = std::abs(down);
    for (std::size_t n = 0; n < kLanes; ++n) {
      const float other = row[n];
      const float z = other - center;
      const float num_steps = std::max(std::abs(du[n]), down_steps);
      const bool counts = (other > 0) & (std::abs(z) <= noise[n] + steepest * num_steps);
      const float one = counts ? 1.0F : 0.0F;
      const float dz = one * z;
      const float dx = one * (du[n] * other + ray_u * z) * per_fx;
      const float dy = one * (down * other + ray_v * z) * per_fy;
      sums[0][n] += one;
      sums[1][n] += dx;
      sums[2][n] += dy;
      sums[3][n] += dz;
      sums[4][n] += dx * dx;
      sums[5][n] += dx * dy;
      sums[6][n] += dx * dz;
      sums[7][n] += dy * dy;
      sums[8][n] += dy * dz;
      sums[9][n] += dz * dz;
    }
  }
  std::array<double, 10> total{};
  for (std::size_t k = 0; k < sums.size(); ++k) {
    for (const float part : sums[k]) total[k] += static_cast<double>(part);
  }
  PatchSums patch;
  patch.count = static_cast<int>(total[0]);
  patch.sum << total[1], total[2], total[3];
  patch.squares << total[4], total[5], total[6], total[5], total[7], total[8], total[6], total[8],
      total[9];
  return patch;
}

std::optional<Eigen::Vector3f> PatchNormal(const PaddedDepth& depth_m,
                                           const PinholeCamera& camera,
                                           int u,
                                           int v) {
  const double center_m = static_cast<double>(depth_m.Row(v)[u]);
  const int radius =
      std::clamp(static_cast<int>(std::lround(kPatchRadius_m * camera.fx / center_m)),
                 kMinPatchRadius_px,
                 kMaxPatchRadius_px);
  const PatchSums patch = SumPatch(depth_m, camera, radius, u, v);
  constexpr int kMinPatch = 8;
  if (patch.count < kMinPatch) return std::nullopt;
  const double count = patch.count;
  const Eigen::Matrix3d covariance =
      patch.squares / count - patch.sum * patch.sum.transpose() / (count * count);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  // Neither a line of pixels nor a corner has a normal.
  const Eigen::Vector3d spread = solver.eigenvalues();
  if (!(spread[1] > 0) || spread[0] > 0.5 * spread[1]) return std::nullopt;
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  const Eigen::Vector3d center = camera.Unproject(u, v, center_m);
  return (normal.dot(center) > 0 ? -normal : normal).cast<float>();
}

struct Pixel {
  std::int16_t u = 0;
  std::int16_t v = 0;
  Eigen::Vector3f point;
};

std::vector<Pixel> CoherentPixels(const ObjectView& view, const PaddedDepth& depth_m) {
  std::vector<Pixel> pixels;
  const float steepest = SteepestPerPixel(view.camera);
  std::vector<std::int32_t> is_coherent(static_cast<std::size_t>(depth_m.width()));
  for (int v = 0; v < view.mask_crop.height(); ++v) {
    FindCoherent(depth_m, steepest, v, is_coherent);
    const std::uint8_t* const in_mask = view.mask_crop.row(v);
    for (int u = 0; u < view.mask_crop.width(); ++u) {
      if (in_mask[u] == 0 || is_coherent[static_cast<std::size_t>(u)] == 0) continue;
      pixels.push_back(
          {static_cast<std::int16_t>(u),
           static_cast<std::int16_t>(v),
           view.camera.Unproject(u, v, static_cast<double>(depth_m.Row(v)[u])).cast<float>()});
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

// One pixel per cell of a cubic raster, the middle one in scan order; nothing where there are more
// than `max_cells`.
std::vector<std::size_t> OnePerCell(const std::vector<Pixel>& pixels,
                                    float cell_m,
                                    std::size_t max_cells) {
  CellNumbers numbers(max_cells + 1);
  std::vector<std::uint32_t> cell_of(pixels.size());
  std::uint64_t last_key = ~std::uint64_t{0};  // no cell's
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<std::int64_t>(std::floor(pixels[n].point[axis] / cell_m));
      key = (key << 21U) | (static_cast<std::uint64_t>(cell) & 0x1FFFFFU);
    }
    // Most pixels fall into the cell of the one beside them.
    cell_of[n] = key == last_key ? cell_of[n - 1] : numbers.NumberOf(key);
    last_key = key;
    if (numbers.count() > max_cells) return {};
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
  // Cells around the origin never merge: a tiny `max_points` takes the first pixels.
  for (; cell_m < kMaxDepth_m; cell_m *= kCoarser) {
    std::vector<std::size_t> thinned = OnePerCell(pixels, cell_m, max_points);
    if (!thinned.empty()) return thinned;
  }
  chosen.resize(max_points);
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
  const PaddedDepth depth_m(view.depth_crop_m);
  const std::vector<Pixel> pixels = CoherentPixels(view, depth_m);
  for (const std::size_t n : Thinned(view, pixels, static_cast<std::size_t>(max_points))) {
    const std::optional<Eigen::Vector3f> normal =
        PatchNormal(depth_m, view.camera, pixels[n].u, pixels[n].v);
    if (!normal) continue;
    result.points_camera.push_back(pixels[n].point);
    result.normals_camera.push_back(*normal);
  }
  return result;
}

}  // namespace deepslam::shape
