// Point sets of segments and objects in the tracking world, with nearest neighbours.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::associate {

class PointCloud {
 public:
  explicit PointCloud(std::vector<Eigen::Vector3f> points);
  ~PointCloud();
  PointCloud(PointCloud&&) noexcept;
  PointCloud& operator=(PointCloud&&) noexcept;

  [[nodiscard]] const std::vector<Eigen::Vector3f>& points() const;
  // Distance to the nearest point; infinite in an empty cloud. Beyond `max_m` it may be infinite as
  // well: most questions are about things that are far apart, and those are answered by the cloud's
  // box.
  [[nodiscard]] double Distance(const Eigen::Vector3f& p,
                                double max_m = std::numeric_limits<double>::infinity()) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;  // none: no points
};

// Mean distance of `from`'s points to their nearest ones in `to`, none counting more than
// `truncation_m`. Only points marked in `counted` where it is not empty. `truncation_m` when there
// is nothing to compare.
[[nodiscard]] double MeanDistance(const std::vector<Eigen::Vector3f>& from,
                                  const PointCloud& to,
                                  double truncation_m,
                                  const std::vector<bool>& counted = {});

// Share of `from`'s points with a point of `to` within `reach_m`; 0 when either is empty.
[[nodiscard]] double ShareNear(const PointCloud& from, const PointCloud& to, double reach_m);

// Points of the mask's pixels with valid depth in the world, thinned evenly to about `max_points`.
[[nodiscard]] std::vector<Eigen::Vector3f> MaskPoints(const Mask& mask,
                                                      const DepthImage& depth_m,
                                                      const PinholeCamera& camera,
                                                      const Pose3& world_from_camera,
                                                      int max_points);

// All points of a thing that is seen again and again: of every cell the first one that came.
class GrowingCloud {
 public:
  // Points that share a cell of side `cell_m` with known ones are not kept. The side is the same
  // each time.
  void Add(std::span<const Eigen::Vector3f> points, double cell_m);

  // In the order in which they came.
  [[nodiscard]] const std::vector<Eigen::Vector3f>& points() const { return points_; }
  // Made when it is asked for and points have come since; several threads may ask at a time when
  // one has asked before.
  [[nodiscard]] const PointCloud& cloud() const;

 private:
  using Cell = std::array<long, 3>;

  std::vector<Eigen::Vector3f> points_;
  std::vector<Cell> cells_;  // taken, ascending
  mutable PointCloud cloud_{{}};
};

}  // namespace deepslam::associate
