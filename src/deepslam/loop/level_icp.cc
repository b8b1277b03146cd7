#include "deepslam/loop/level_icp.h"

#include <algorithm>
#include <cstddef>

#include "deepslam/loop/correction.h"

namespace deepslam::loop {
namespace {

constexpr int kIcpSteps = 20;  // ten until the radius is at its last, ten more to converge
constexpr double kFirstRadius_m = 0.30;  // as far as constellations may be off
constexpr double kShrink = 0.85;  // of the radius, a step: ten from 30 cm to the 6 cm of loops

// How many points have a neighbour.
std::size_t AddNeighbours(const Belonging& cloud,
                          const Pose3& b_from_a,
                          const Eigen::Quaterniond& level_from_world,
                          double radius_m,
                          CorrectionFit& fit) {
  std::size_t count = 0;
  for (const Eigen::Vector3f& p : cloud.points_a) {
    const Eigen::Vector3d moved = b_from_a * p.cast<double>();
    const Eigen::Vector3f* nearest = cloud.points_b->Nearest(moved.cast<float>(), radius_m);
    if (nearest == nullptr) continue;
    fit.AddPoint(level_from_world * nearest->cast<double>(), level_from_world * p.cast<double>());
    ++count;
  }
  return count;
}

}  // namespace

std::optional<Pose3> AlignLevel(std::span<const Belonging> clouds,
                                const Pose3& start,
                                const Eigen::Quaterniond& level_from_world,
                                double last_radius_m) {
  Pose3 b_from_a = start;
  double radius_m = kFirstRadius_m;
  for (int step = 0; step < kIcpSteps; ++step) {
    CorrectionFit fit;
    std::size_t count = 0;
    for (const Belonging& cloud : clouds)
      count += AddNeighbours(cloud, b_from_a, level_from_world, radius_m, fit);
    if (count < kMinComparedPoints) return std::nullopt;
    b_from_a = fit.Solve(radius_m, 1.0).InWorld(level_from_world);
    radius_m = std::max(last_radius_m, kShrink * radius_m);
  }
  return b_from_a;
}

}  // namespace deepslam::loop
