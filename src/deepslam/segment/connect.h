// Groups of points that lie near each other in space.
#pragma once

#include <algorithm>
#include <cstddef>
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
  template <typename Weight>
  [[nodiscard]] int Heaviest(const Weight& weight) const {
    std::vector<double> sums(static_cast<std::size_t>(count), 0.0);
    for (std::size_t i = 0; i < of_point.size(); ++i) {
      sums[static_cast<std::size_t>(of_point[i])] += weight(i);
    }
    if (sums.empty()) return -1;
    return static_cast<int>(std::max_element(sums.begin(), sums.end()) - sums.begin());
  }
};

// Points belong to one group when a chain of points leads from one to the other with steps of about
// `gap_m` at most (between 0.7 and 1.4 times that: cells of a grid are compared, not points). Up to
// 700 thousand times `gap_m` from the camera.
[[nodiscard]] Groups ConnectPoints(std::span<const PixelPoint> points, double gap_m);

}  // namespace deepslam::segment
