#include "deepslam/shape/view_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>

#include "deepslam/core/unfilled.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::shape {
namespace {

constexpr float kMaxDepth_m = 20.0F;  // no RGB-D camera of rooms measures further
constexpr double kPatchRadius_m =
    0.02;  // normals: wide against depth noise, small against furniture edges
constexpr int kMinPatchRadius_px = 2;  // 5 x 5: fewer pixels do not outweigh far depth's noise
constexpr int kMaxPatchRadius_px = 6;  // bounds the time of close-ups

bool IsUsable(float depth_m) { return depth_m > 0 && depth_m < kMaxDepth_m; }

// Depth difference between neighbouring pixels that a real surface can have, per metre of depth and
// pixel between them, and beyond that: slopes up to 80 degrees against the image plane, and 1 cm of
// noise.
float SteepestPerPixel(const PinholeCamera& camera) {
  constexpr float kSteepestSlope = 5.7F;  // tan 80 deg
  return kSteepestSlope / static_cast<float>(camera.fx);
}
constexpr float kNoise_m = 0.01F;  // of depth between neighbours, near the camera

// The depth of a view with so much of nothing around it that no patch leaves the image, unusable
// depth being 0.
class PaddedDepth {
 public:
  static constexpr int kMarginRows = kMaxPatchRadius_px;
  static constexpr int kMarginColumns = 16;  // two vectors of kLanes (below)

  explicit PaddedDepth(const DepthImage& depth_m)
      : padded_m_(depth_m.width() + 2 * kMarginColumns, depth_m.height() + 2 * kMarginRows, 0.0F) {
    for (int v = 0; v < depth_m.height(); ++v) {
      std::transform(depth_m.row(v),
                     depth_m.row(v) + depth_m.width(),
                     padded_m_.row(v + kMarginRows) + kMarginColumns,
                     [](float depth) { return IsUsable(depth) ? depth : 0.0F; });
    }
  }

  // Of the image: pixel 0 of the row, with kMarginColumns before it and behind its last.
  [[nodiscard]] const float* Row(int v) const {
    return padded_m_.row(v + kMarginRows) + kMarginColumns;
  }
  [[nodiscard]] int width() const { return padded_m_.width() - 2 * kMarginColumns; }
  [[nodiscard]] int height() const { return padded_m_.height() - 2 * kMarginRows; }

 private:
  DepthImage padded_m_;
};

// Columns [first, end) of a row.
struct Span {
  int first = 0;
  int end = 0;
};

// From the first to the last column that belongs to the mask.
Span MaskedSpan(const Mask& mask, int v) {
  const std::uint8_t* const row = mask.row(v);
  Span span{0, mask.width()};
  while (span.first < span.end && row[span.first] == 0) ++span.first;
  while (span.end > span.first && row[span.end - 1] == 0) --span.end;
  return span;
}

// Which pixels of the mask, 1 or 0, have neighbours that mostly agree with them: no edges, no
// flying pixels.
DEEPSLAM_WIDE_VECTORS void FindCoherent(const PaddedDepth& depth_m,
                                        const std::uint8_t* in_mask,
                                        float steepest,
                                        int v,
                                        Span span,
                                        std::vector<std::int32_t>& is_coherent) {
  // Of 8; a pixel at a straight edge, which may mix depths, has 5.
  constexpr std::int32_t kMinAgreeing = 6;
  const float* const above = depth_m.Row(v - 1);
  const float* const row = depth_m.Row(v);
  const float* const below = depth_m.Row(v + 1);
  std::int32_t* const coherent = is_coherent.data();
#pragma GCC ivdep
  for (int u = span.first; u < span.end; ++u) {
    const float center = row[u];
    const float limit = kNoise_m + steepest * center;
    const auto agrees = [&](float other) -> std::int32_t {
      return (other > 0) & (std::abs(other - center) <= limit);
    };
    const std::int32_t agreeing = agrees(above[u - 1]) + agrees(above[u]) + agrees(above[u + 1]) +
                                  agrees(row[u - 1]) + agrees(row[u + 1]) + agrees(below[u - 1]) +
                                  agrees(below[u]) + agrees(below[u + 1]);
    coherent[u] = (in_mask[u] != 0) & (center > 0) & (agreeing >= kMinAgreeing);
  }
}

// Sums over the pixels of a patch that belong to its middle's surface, of their offsets from it.
struct PatchSums {
  int count = 0;
  Eigen::Vector3d sum;
  Eigen::Matrix3d squares;
};

// Neighbouring columns of a patch. Spelt out as vectors because the compiler keeps sums of arrays
// in memory; where processors have none so wide, it takes two.
constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using LaneBits = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));
static_assert(2 * kLanes > 2 * kMaxPatchRadius_px && 2 * kLanes <= PaddedDepth::kMarginColumns);

// Offsets are taken from differences of depth and pixels, which single precision holds well.
DEEPSLAM_WIDE_VECTORS PatchSums
SumPatch(const PaddedDepth& depth_m, const PinholeCamera& camera, int radius, int u, int v) {
  const float center = depth_m.Row(v)[u];
  const float steepest = SteepestPerPixel(camera) * center;
  const auto ray_u = static_cast<float>(u - camera.cx);
  const auto ray_v = static_cast<float>(v - camera.cy);
  const auto per_fx = static_cast<float>(1.0 / camera.fx);
  const auto per_fy = static_cast<float>(1.0 / camera.fy);
  constexpr Lanes kLaneNumbers = {0, 1, 2, 3, 4, 5, 6, 7};
  constexpr LaneBits kNoSign = LaneBits{} + 0x7FFFFFFF;
  constexpr Lanes kOne = Lanes{} + 1.0F;
  std::array<double, 10> total{};
  for (int first = -radius; first <= radius; first += kLanes) {
    const Lanes du = kLaneNumbers + static_cast<float>(first);
    const Lanes du_steps = reinterpret_cast<Lanes>(reinterpret_cast<LaneBits>(du) & kNoSign);
    const LaneBits in_patch = du <= static_cast<float>(radius);
    std::array<Lanes, 10> sums{};
    for (int dv = -radius; dv <= radius; ++dv) {
      Lanes other;
      std::memcpy(&other, depth_m.Row(v + dv) + u + first, sizeof(other));
      const auto down = static_cast<float>(dv);
      const float down_steps = std::abs(down);
      const Lanes z = other - center;
      const Lanes gap = reinterpret_cast<Lanes>(reinterpret_cast<LaneBits>(z) & kNoSign);
      const Lanes num_steps = du_steps > down_steps ? du_steps : Lanes{} + down_steps;
      const LaneBits counts = in_patch & (other > 0.0F) & (gap <= kNoise_m + steepest * num_steps);
      const Lanes one = reinterpret_cast<Lanes>(reinterpret_cast<LaneBits>(kOne) & counts);
      const Lanes dz = one * z;
      const Lanes dx = one * (du * other + ray_u * z) * per_fx;
      const Lanes dy = one * (down * other + ray_v * z) * per_fy;
      sums[0] += one;
      sums[1] += dx;
      sums[2] += dy;
      sums[3] += dz;
      sums[4] += dx * dx;
      sums[5] += dx * dy;
      sums[6] += dx * dz;
      sums[7] += dy * dy;
      sums[8] += dy * dz;
      sums[9] += dz * dz;
    }
    for (std::size_t k = 0; k < sums.size(); ++k) {
      for (int n = 0; n < kLanes; ++n) total[k] += static_cast<double>(sums[k][n]);
    }
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
  constexpr int kMinPatch = 8;  // pixels; the normal of fewer is noise
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

// Pixels in scan order and their points, one array per quantity.
struct Pixels {
  UnfilledVector<std::int16_t> u;
  UnfilledVector<std::int16_t> v;
  UnfilledVector<float> x_m;
  UnfilledVector<float> y_m;
  UnfilledVector<float> z_m;

  [[nodiscard]] std::size_t size() const { return z_m.size(); }
  [[nodiscard]] Eigen::Vector3f point(std::size_t n) const { return {x_m[n], y_m[n], z_m[n]}; }
  void Resize(std::size_t size) {
    u.resize(size);
    v.resize(size);
    x_m.resize(size);
    y_m.resize(size);
    z_m.resize(size);
  }
};

// Columns of a row where there is a 1, in order; their number. Room for one more is needed.
std::size_t ColumnsOf(const std::vector<std::int32_t>& ones, Span span, std::int16_t* columns) {
  std::size_t count = 0;
  for (int u = span.first; u < span.end; ++u) {
    columns[count] = static_cast<std::int16_t>(u);
    count += static_cast<std::size_t>(ones[static_cast<std::size_t>(u)]);
  }
  return count;
}

Pixels CoherentPixels(const ObjectView& view, const PaddedDepth& depth_m) {
  const float steepest = SteepestPerPixel(view.camera);
  const auto width = static_cast<std::size_t>(view.mask_crop.width());
  std::vector<std::int32_t> is_coherent(width);
  std::vector<double> rays_x(width);
  for (std::size_t u = 0; u < width; ++u)
    rays_x[u] = view.camera.Ray(static_cast<double>(u), 0).x();
  Pixels pixels;
  pixels.Resize(view.mask_crop.size() + 1);
  std::size_t count = 0;
  for (int v = 0; v < view.mask_crop.height(); ++v) {
    const Span span = MaskedSpan(view.mask_crop, v);
    FindCoherent(depth_m, view.mask_crop.row(v), steepest, v, span, is_coherent);
    const float* const row_m = depth_m.Row(v);
    const double ray_y = view.camera.Ray(0, v).y();
    const std::size_t end = count + ColumnsOf(is_coherent, span, pixels.u.data() + count);
    for (; count < end; ++count) {
      const std::int16_t u = pixels.u[count];
      const float z = row_m[u];
      pixels.v[count] = static_cast<std::int16_t>(v);
      pixels.x_m[count] =
          static_cast<float>(static_cast<double>(z) * rays_x[static_cast<std::size_t>(u)]);
      pixels.y_m[count] = static_cast<float>(static_cast<double>(z) * ray_y);
      pixels.z_m[count] = z;
    }
  }
  pixels.Resize(count);
  return pixels;
}

// Cells of a cubic raster, numbered in the order in which they are met.
class CellNumbers {
 public:
  explicit CellNumbers(std::size_t max_cells)
      : slots_(std::bit_ceil(2 * max_cells + 1), kEmptySlot), keys_(slots_.size()) {}

  std::uint32_t NumberOf(std::uint64_t key) {
    const std::size_t last = slots_.size() - 1;
    std::size_t at = (key * 0x9E3779B97F4A7C15ULL >> 32U) & last;
    while (slots_[at] != kEmptySlot && keys_[at] != key) at = (at + 1) & last;
    if (slots_[at] == kEmptySlot) {
      slots_[at] = count_++;
      keys_[at] = key;
    }
    return slots_[at];
  }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  static constexpr std::uint32_t kEmptySlot = 0xFFFFFFFFU;  // an empty slot
  std::vector<std::uint32_t> slots_;
  std::vector<std::uint64_t> keys_;
  std::uint32_t count_ = 0;
};

// Cells of every `step`-th pixel. Only absurd intrinsics have cells beyond 31 bits.
DEEPSLAM_WIDE_VECTORS void FindCells(const Pixels& pixels,
                                     std::size_t step,
                                     float cell_m,
                                     std::vector<std::uint64_t>& cells) {
  const float* const x_m = pixels.x_m.data();
  const float* const y_m = pixels.y_m.data();
  const float* const z_m = pixels.z_m.data();
  std::uint64_t* const keys = cells.data();
  const std::size_t count = cells.size();
  const auto along = [cell_m](float at_m) -> std::uint64_t {
    const float scaled = at_m / cell_m;
    const auto towards_zero = static_cast<std::int32_t>(scaled);
    const std::int32_t cell = towards_zero - (static_cast<float>(towards_zero) > scaled ? 1 : 0);
    return static_cast<std::uint32_t>(cell) & 0x1FFFFFU;
  };
  if (step == 1) {
    for (std::size_t n = 0; n < count; ++n) {
      keys[n] = along(x_m[n]) << 42U | along(y_m[n]) << 21U | along(z_m[n]);
    }
  } else {
    for (std::size_t n = 0; n < count; ++n) {
      const std::size_t at = n * step;
      keys[n] = along(x_m[at]) << 42U | along(y_m[at]) << 21U | along(z_m[at]);
    }
  }
}

// Whether a few of the pixels already fill too many cells.
bool ClearlyMoreCells(const Pixels& pixels, float cell_m, std::size_t max_cells) {
  constexpr std::size_t kPerCell = 8;  // enough to meet nearly all
  const std::size_t step = pixels.size() / (kPerCell * max_cells);
  if (step < 2) return false;
  std::vector<std::uint64_t> cells(pixels.size() / step);
  FindCells(pixels, step, cell_m, cells);
  CellNumbers numbers(max_cells + 1);
  for (const std::uint64_t cell : cells) {
    numbers.NumberOf(cell);
    if (numbers.count() > max_cells) return true;
  }
  return false;
}

// One pixel per cell of a cubic raster, the middle one in scan order; nothing where there are more
// than `max_cells`.
std::vector<std::size_t> OnePerCell(const Pixels& pixels, float cell_m, std::size_t max_cells) {
  if (ClearlyMoreCells(pixels, cell_m, max_cells)) return {};
  std::vector<std::uint64_t> cells(pixels.size());
  FindCells(pixels, 1, cell_m, cells);
  CellNumbers numbers(max_cells + 1);
  // Most pixels fall into the cell of the one beside them.
  struct Run {
    std::uint32_t cell, size;
  };
  std::vector<Run> runs;
  for (std::size_t n = 0; n < cells.size();) {
    const std::size_t first = n;
    const std::uint64_t cell = cells[n];
    while (n < cells.size() && cells[n] == cell) ++n;
    runs.push_back({numbers.NumberOf(cell), static_cast<std::uint32_t>(n - first)});
    if (numbers.count() > max_cells) return {};
  }
  std::vector<std::uint32_t> until_middle(numbers.count(), 0);
  for (const Run& run : runs) until_middle[run.cell] += run.size;
  for (std::uint32_t& count : until_middle) count = count / 2 + 1;
  std::vector<std::size_t> chosen;
  chosen.reserve(numbers.count());
  std::size_t begin = 0;
  for (const Run& run : runs) {
    std::uint32_t& left = until_middle[run.cell];  // 0 behind the middle
    if (left > 0 && left <= run.size) chosen.push_back(begin + left - 1);
    left -= std::min(left, run.size);
    begin += run.size;
  }
  return chosen;
}

std::vector<std::size_t> Thinned(const ObjectView& view,
                                 const Pixels& pixels,
                                 std::size_t max_points) {
  std::vector<std::size_t> chosen(pixels.size());
  for (std::size_t n = 0; n < chosen.size(); ++n) chosen[n] = n;
  if (chosen.size() <= max_points) return chosen;
  double area_m2 = 0;
  const double px_per_rad2 = view.camera.fx * view.camera.fy;
  for (const float z : pixels.z_m) area_m2 += z * z / px_per_rad2;
  constexpr float kCoarser = 1.15F;  // about a quarter fewer cells a try
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
  const Pixels pixels = CoherentPixels(view, depth_m);
  for (const std::size_t n : Thinned(view, pixels, static_cast<std::size_t>(max_points))) {
    const std::optional<Eigen::Vector3f> normal =
        PatchNormal(depth_m, view.camera, pixels.u[n], pixels.v[n]);
    if (!normal) continue;
    result.points_camera.push_back(pixels.point(n));
    result.normals_camera.push_back(*normal);
  }
  return result;
}

}  // namespace deepslam::shape
