#include "deepslam/ground/ground_points.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "deepslam/core/order_statistics.h"
#include "deepslam/geometry/depth_noise.h"

namespace deepslam::ground {
namespace {

constexpr int kGridWidth = 160;

class Grid {
 public:
  Grid(const DepthImage& depth_m, const PinholeCamera& camera, double max_depth_m)
      : step_(std::max(1, camera.width / kGridWidth)),
        camera_(camera),
        depth_m_(camera.width / step_, camera.height / step_) {
    const float max_depth = static_cast<float>(max_depth_m);
    for (int v = 0; v < depth_m_.height(); ++v) {
      for (int u = 0; u < depth_m_.width(); ++u)
        depth_m_(u, v) = BlockMedian(depth_m, u, v, max_depth);
    }
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
  float BlockMedian(const DepthImage& depth_m, int u, int v, float max_depth) const {
    std::vector<float> values;
    for (int dv = 0; dv < step_; ++dv) {
      for (int du = 0; du < step_; ++du) {
        const float z = depth_m(u * step_ + du, v * step_ + dv);
        if (z > 0.1F && z <= max_depth) values.push_back(z);
      }
    }
    // Half-empty blocks lie at edges.
    if (2 * values.size() < static_cast<std::size_t>(step_ * step_)) return 0;
    return Median(values);
  }

  [[nodiscard]] Eigen::Vector3f Unproject(int u, int v, float z) const {
    const double middle = 0.5 * (step_ - 1);
    return camera_.Unproject(u * step_ + middle, v * step_ + middle, static_cast<double>(z))
        .cast<float>();
  }

  int step_;
  const PinholeCamera& camera_;
  DepthImage depth_m_;
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
