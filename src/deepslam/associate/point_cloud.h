// Point sets of segments and objects in the tracking world, with nearest neighbours.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
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
  std::unique_ptr<Impl> impl_;
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

// The first point of every cell of side `cell_m`, in order.
[[nodiscard]] std::vector<Eigen::Vector3f> Thinned(const std::vector<Eigen::Vector3f>& points,
                                                   double cell_m);

}  // namespace deepslam::associate
