#include "deepslam/ground/ground_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/depth_noise.h"

namespace deepslam::ground {
namespace {

constexpr int kGridWidth = 160;  // columns; medians of blocks of 4 x 4 pixels of a 640 wide image

// Blocks of pixels side by side in a row of the grid.
constexpr std::size_t kSortedColumns = 16;

// Sorts each of kSortedColumns columns of `count` values: Batcher's odd-even merge sort.
DEEPSLAM_WIDE_VECTORS void SortColumns(std::size_t count, std::vector<float>& values) {
  const auto exchange = [&](std::size_t a, std::size_t b) {
    float* const lower = values.data() + a * kSortedColumns;
    float* const upper = values.data() + b * kSortedColumns;
#pragma GCC ivdep
    for (std::size_t n = 0; n < kSortedColumns; ++n) {
      const float x = lower[n];
      const float y = upper[n];
      lower[n] = std::min(x, y);
      upper[n] = std::max(x, y);
    }
  };
  for (std::size_t run = 1; run < count; run *= 2) {
    for (std::size_t step = run; step > 0; step /= 2) {
      for (std::size_t first = step % run; first + step < count; first += 2 * step) {
        for (std::size_t n = first; n < first + step && n + step < count; ++n) {
          if (n / (2 * run) == (n + step) / (2 * run)) exchange(n, n + step);
        }
      }
    }
  }
}

class Grid {
 public:
  Grid(const DepthImage& depth_m, const PinholeCamera& camera, double max_depth_m)
      : step_(std::max(1, camera.width / kGridWidth)),
        depth_m_(camera.width / step_, camera.height / step_) {
    const double middle = 0.5 * (step_ - 1);
    for (int u = 0; u < width(); ++u) rays_x_.push_back(camera.Ray(u * step_ + middle, 0).x());
    for (int v = 0; v < height(); ++v) rays_y_.push_back(camera.Ray(0, v * step_ + middle).y());
    const float max_depth = static_cast<float>(max_depth_m);
    for (int v = 0; v < depth_m_.height(); ++v) FindMedians(depth_m, v, max_depth);
  }

  [[nodiscard]] int step() const { return step_; }
  [[nodiscard]] int width() const { return depth_m_.width(); }
  [[nodiscard]] int height() const { return depth_m_.height(); }

  [[nodiscard]] std::optional<GroundPoint> PointAt(int u, int v) const {
    const float z = depth_m_(u, v);
    const float left = depth_m_(u - 1, v), right = depth_m_(u + 1, v);
    const float up = depth_m_(u, v - 1), down = depth_m_(u, v + 1);
    if (!(z > 0 && left > 0 && right > 0 && up > 0 && down > 0)) return std::nullopt;
    const float sigma = DepthSigmaM(z);
    const float tolerance = 4 * sigma + 0.01F * z;
    if (std::abs(left + right - 2 * z) > tolerance || std::abs(up + down - 2 * z) > tolerance)
      return std::nullopt;
    const Eigen::Vector3f along_u = Unproject(u + 1, v, right) - Unproject(u - 1, v, left);
    const Eigen::Vector3f along_v = Unproject(u, v + 1, down) - Unproject(u, v - 1, up);
    const Eigen::Vector3f cross = along_v.cross(along_u);
    const float norm = cross.norm();
    if (!(norm > 0)) return std::nullopt;
    return GroundPoint{Unproject(u, v, z), cross / norm, sigma};
  }

 private:
  // Upper medians of the blocks of a row, 0 where half of the pixels are not usable: such blocks
  // lie at edges.
  void FindMedians(const DepthImage& depth_m, int v, float max_depth) {
    const auto block_px = static_cast<std::size_t>(step_) * static_cast<std::size_t>(step_);
    std::vector<float> values(block_px * kSortedColumns);
    for (int first = 0; first < depth_m_.width(); first += static_cast<int>(kSortedColumns)) {
      const int end = std::min(depth_m_.width(), first + static_cast<int>(kSortedColumns));
      std::array<std::size_t, kSortedColumns> num_usable{};
      auto value = values.begin();
      for (int dv = 0; dv < step_; ++dv) {
        const float* const row = depth_m.row(v * step_ + dv);
        for (int du = 0; du < step_; ++du, value += kSortedColumns) {
          for (int u = first; u < end; ++u) {
            const float z = row[u * step_ + du];
            const bool usable = z > 0.1F && z <= max_depth;
            const int lane = u - first;
            value[lane] = usable ? z : std::numeric_limits<float>::infinity();
            num_usable[static_cast<std::size_t>(lane)] += usable ? 1U : 0U;
          }
        }
      }
      SortColumns(block_px, values);
      for (int u = first; u < end; ++u) {
        const auto lane = static_cast<std::size_t>(u - first);
        const std::size_t count = num_usable[lane];
        depth_m_(u, v) = 2 * count < block_px ? 0.0F : values[count / 2 * kSortedColumns + lane];
      }
    }
  }

  [[nodiscard]] Eigen::Vector3f Unproject(int u, int v, float z) const {
    const double ray_x = rays_x_[static_cast<std::size_t>(u)];
    const double ray_y = rays_y_[static_cast<std::size_t>(v)];
    return {static_cast<float>(z * ray_x), static_cast<float>(z * ray_y), z};
  }

  int step_;
  DepthImage depth_m_;
  std::vector<double> rays_x_;  // through the middles of blocks, by column
  std::vector<double> rays_y_;  // by row
};

}  // namespace

GroundPoints ExtractGroundPoints(const DepthImage& depth_m,
                                 const PinholeCamera& camera,
                                 double max_depth_m) {
  GroundPoints result;
  if (depth_m.empty() || depth_m.width() != camera.width || depth_m.height() != camera.height)
    return result;
  const Grid grid(depth_m, camera, max_depth_m);
  result.step_px = grid.step();
  result.num_grid = grid.width() * grid.height();
  for (int v = 1; v + 1 < grid.height(); ++v) {
    for (int u = 1; u + 1 < grid.width(); ++u) {
      if (const auto point = grid.PointAt(u, v)) result.points.push_back(*point);
    }
  }
  return result;
}

}  // namespace deepslam::ground
