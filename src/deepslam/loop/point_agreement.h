// How well two point sets agree: nearest neighbours through a kd-tree.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/pose.h"

namespace deepslam::loop {

// What clouds are thinned to before they are compared.
inline constexpr double kThinnedCell_m = 0.03;
// Fewer say nothing.
inline constexpr std::size_t kMinComparedPoints = 30;

class PointIndex {
 public:
  explicit PointIndex(std::vector<Eigen::Vector3f> points);
  ~PointIndex();
  PointIndex(PointIndex&&) noexcept;
  PointIndex& operator=(PointIndex&&) noexcept;

  [[nodiscard]] std::size_t size() const { return points_.size(); }
  // The nearest point within `radius_m`, nullptr where there is none.
  [[nodiscard]] const Eigen::Vector3f* Nearest(const Eigen::Vector3f& p, double radius_m) const;

 private:
  struct Tree;
  std::vector<Eigen::Vector3f> points_;
  std::unique_ptr<Tree> tree_;
};

// At most one point per cube of `cell_m`, the first in the order given; what is not finite is left
// out. The result does not depend on anything but the input.
[[nodiscard]] std::vector<Eigen::Vector3f> Thinned(std::span<const Eigen::Vector3f> points,
                                                   double cell_m);

// Height up to which what stands around an object counts as ground: its feet (the lowest points but
// 2 %) and 0.1 m. Below everything for no points.
[[nodiscard]] double GroundTop_m(std::span<const Eigen::Vector3f> object_world,
                                 const Eigen::Vector3d& up_world);

// Share of b_from_a * points_a within `radius_m` of the index; 0 for no points.
[[nodiscard]] double AgreeingShare(std::span<const Eigen::Vector3f> points_a,
                                   const Pose3& b_from_a,
                                   const PointIndex& points_b,
                                   double radius_m);

}  // namespace deepslam::loop
