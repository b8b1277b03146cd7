// Groups of points that lie near each other in space.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace deepslam::segment {

struct PixelPoint {
  int u = 0;
  int v = 0;
  Eigen::Vector3f p_camera = Eigen::Vector3f::Zero();
};

struct Groups {
  std::vector<int> of_point;  // counted from 0 in the order of first points
  int count = 0;

  // The group with the largest sum of weights (index of a point -> weight); -1 when there are no
  // points.
  [[nodiscard]] int Heaviest(const std::function<double(std::size_t)>& weight) const;
};

// Points belong to one group when a chain of points leads from one to the other with steps of about
// `gap_m` at most (between 0.7 and 1.4 times that: cells of a grid are compared, not points).
[[nodiscard]] Groups ConnectPoints(std::span<const PixelPoint> points, double gap_m);

}  // namespace deepslam::segment
