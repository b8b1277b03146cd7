// Places a model of roughly known size into an object's level cloud and says how well it agrees
// with all depth.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/propose/coarse_shape.h"
#include "deepslam/shape/depth_view.h"

namespace deepslam::propose {

// A model standing in the level frame: p_level = Rz(yaw) * diag(metres per object unit) * p_object
// + position.
struct Placement {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();    // of the model's box along its own axes
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();  // of the box's footprint
  double bottom_m = 0;                                 // height of the box's lowest point
  double yaw_rad = 0;
};

struct FitTerms {
  double catalogue_sigma = 0.15;  // prior on the log of the stretch, relative to `prior_size_m`
  double bottom_sigma_m = 0.02;   // prior on the bottom's height
  double point_sigma_m = 0.02;    // of the measured points
};

// Gauss-Newton on position, yaw and size against the points' signed distances, robust, with the
// priors of `terms`.
[[nodiscard]] Placement RefinePlacement(const CoarseShape& shape,
                                        const Placement& start,
                                        const Eigen::Vector3d& prior_size_m,
                                        std::span<const Eigen::Vector3f> points_level,
                                        const FitTerms& terms);

// Agreement in [0, 1]: harmonic mean of the share of points that lie on the model's surface and the
// share of the model's surface that the views confirm, of what they could see. Where that turns out
// to be no more than `to_beat`, some number that is no more either: the placement is not looked at
// to the end.
[[nodiscard]] double ScorePlacement(const CoarseShape& shape,
                                    const Placement& placement,
                                    std::span<const Eigen::Vector3f> points_level,
                                    std::span<const shape::DepthView> views,
                                    double tolerance_m,
                                    double to_beat = 0);

}  // namespace deepslam::propose
