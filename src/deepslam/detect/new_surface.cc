#include "deepslam/detect/new_surface.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace deepslam::detect {
namespace {

// Less than the smallest thing that is mapped by default: a cell shows one or two.
constexpr double kCellM = 0.2;
// Pixels between two that are looked at: 11 cm at kMaxDepthM in a Kinect's pictures.
constexpr int kStridePx = 12;
// Detections of what is farther are of no thing (segment.max_depth_m).
constexpr double kMaxDepthM = 5.0;
// Of a unit vector's component: thirds of its range tell 26 directions, 45 degrees or so apart.
constexpr double kThirds = 1.5;
// Views of a cell from about one place after which another one tells nothing new.
constexpr int kNumViews = 2;
// Of a frame's cells. What stands beside much that is known shows in few of them: with twice as much
// homes have one box in forty less at IoU 0.5 and one class in a hundred; with less next to all
// keyframes are looked at.
constexpr double kMinNewShare = 0.15;

std::uint64_t Coordinate(double p_m) {
  constexpr std::int64_t kOrigin = 1 << 15;  // cells: the middle of 16 bits
  return static_cast<std::uint64_t>(std::llround(std::floor(p_m / kCellM)) + kOrigin) & 0xffffU;
}

std::uint64_t Third(double component) {
  return static_cast<std::uint64_t>(std::clamp((component + 1) * kThirds, 0.0, 2.0));
}

SeenCell CellAt(const Eigen::Vector3d& p_world, const Eigen::Vector3d& camera_world) {
  const Eigen::Vector3d towards = camera_world - p_world;
  const double distance_m = towards.norm();
  const Eigen::Vector3d direction = towards / distance_m;
  // Octaves: at twice the distance a thing has a quarter of the pixels. From 1/8 m on.
  const auto octave = static_cast<std::uint64_t>(std::clamp(std::log2(distance_m) + 3, 0.0, 15.0));
  SeenCell cell = octave;
  for (int axis = 0; axis < 3; ++axis) cell = cell << 2U | Third(direction[axis]);
  for (int axis = 0; axis < 3; ++axis) cell = cell << 16U | Coordinate(p_world[axis]);
  return cell;
}

}  // namespace

std::vector<SeenCell> SeenCells(const DepthImage& depth_m,
                                const PinholeCamera& camera,
                                const Pose3& world_from_camera) {
  std::vector<SeenCell> cells;
  for (int v = kStridePx / 2; v < depth_m.height(); v += kStridePx) {
    for (int u = kStridePx / 2; u < depth_m.width(); u += kStridePx) {
      const double z_m = depth_m(u, v);
      if (z_m <= 0 || z_m > kMaxDepthM) continue;
      const Eigen::Vector3d p_camera = z_m * camera.Ray(u, v);
      cells.push_back(CellAt(world_from_camera * p_camera, world_from_camera.translation_m));
    }
  }
  std::ranges::sort(cells);
  const auto [first, last] = std::ranges::unique(cells);
  cells.erase(first, last);
  return cells;
}

std::vector<bool> ShowNewSurface(std::span<const std::vector<SeenCell>> frames) {
  std::unordered_map<SeenCell, int> num_views;
  std::vector<bool> show_new;
  for (const std::vector<SeenCell>& cells : frames) {
    const auto is_new = [&](SeenCell cell) { return num_views[cell] < kNumViews; };
    const auto num_new = std::ranges::count_if(cells, is_new);
    show_new.push_back(static_cast<double>(num_new) >=
                       kMinNewShare * static_cast<double>(cells.size()));
    if (!show_new.back()) continue;
    for (const SeenCell cell : cells) ++num_views[cell];
  }
  return show_new;
}

}  // namespace deepslam::detect
