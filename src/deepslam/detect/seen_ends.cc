#include "deepslam/detect/seen_ends.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace deepslam::detect {
namespace {

constexpr double kShadowShare = 0.05;   // of the image width: the sensor's shadow beside a thing
constexpr double kStepBehind_m = 0.10;  // what lies farther than this behind is another thing
constexpr double kMinEndShare = 0.6;    // of the rows; beside the others depth is missing or noise

struct PixelPlace {
  int u = 0;
  int v = 0;
};

// Share of image rows in which the cluster's left end (`side` -1) or right end (+1) is seen to end.
double EndShare(const Frame& frame,
                const PinholeCamera& camera,
                const Plane& ground_camera,
                const Mask& wall,
                const Cluster& cluster,
                int side) {
  std::vector<PixelPlace> ends;  // the outermost of each row
  for (const GridPoint& p : cluster.points) {
    if (ends.empty() || ends.back().v != p.v) {
      ends.push_back({p.u, p.v});
    } else if (side > 0) {
      ends.back().u = p.u;
    }
  }
  const int reach = static_cast<int>(std::lround(kShadowShare * frame.depth_m.width()));
  std::size_t num_ends = 0;
  for (const auto& [u_end, v] : ends) {
    const double depth_m = frame.depth_m(u_end, v);
    for (int u = u_end + side, k = 0; k < reach && frame.depth_m.Contains(u, v); u += side, ++k) {
      const double beyond_m = frame.depth_m(u, v);
      if (!(beyond_m > 0)) continue;
      const double height_m = ground_camera.SignedDistance(camera.Unproject(u, v, beyond_m));
      const bool floor = height_m < kHeightNoise_m + kHeightNoisePerM2 * beyond_m * beyond_m;
      const bool is_end = floor || wall(u, v) != 0 || beyond_m > depth_m + kStepBehind_m;
      num_ends += is_end ? 1U : 0U;
      break;
    }
  }
  return static_cast<double>(num_ends) / static_cast<double>(ends.size());
}

}  // namespace

double FreeShare(const GroundGrid& grid, const Components& components, const Cluster& cluster) {
  const int reach =
      std::max(1, static_cast<int>(std::lround(ClusterOptions::kFreeMargin_m / grid.cell_m)));
  int num_front = 0;
  int num_free = 0;
  for (const int cell : cluster.cells) {
    const Eigen::Vector2d place(cell / grid.side - grid.side / 2, cell % grid.side - grid.side / 2);
    if (place.norm() < 2.0) continue;
    const Eigen::Vector2d step = -place.normalized();
    bool front = true;
    bool floor = false;
    for (int k = 1; k <= reach && front; ++k) {
      const Eigen::Vector2d q = place + k * step;
      const int i = static_cast<int>(std::lround(q.x())) + grid.side / 2;
      const int j = static_cast<int>(std::lround(q.y())) + grid.side / 2;
      const auto index = static_cast<std::size_t>(i * grid.side + j);
      if (static_cast<int>(index) != cell && components.of_cell[index] == cluster.component)
        front = false;
      floor = floor || (grid.kinds[index] & kFloor) != 0;
    }
    num_front += front ? 1 : 0;
    num_free += front && floor ? 1 : 0;
  }
  return num_front > 0 ? static_cast<double>(num_free) / num_front : 0.0;
}

bool EndsAreSeen(const Frame& frame,
                 const PinholeCamera& camera,
                 const Plane& ground_camera,
                 const Mask& wall,
                 const Cluster& cluster) {
  return EndShare(frame, camera, ground_camera, wall, cluster, -1) >= kMinEndShare &&
         EndShare(frame, camera, ground_camera, wall, cluster, 1) >= kMinEndShare;
}

}  // namespace deepslam::detect
