// Where a model of roughly known size stands by all depth of an object, and how its proportions
// have to change for it.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/propose/coarse_shape.h"
#include "deepslam/propose/fit_model.h"
#include "deepslam/propose/level_box.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/scene/layout.h"
#include "deepslam/shape/depth_view.h"

namespace deepslam::propose {

// What an object's depth says, prepared for all models.
struct MeasuredDepth {
  LevelCloud cloud;
  std::vector<Eigen::Vector3f> fit_points;  // some of the cloud's, level frame
  std::vector<shape::DepthView> views;
  std::vector<LevelBox> boxes;  // at a dozen yaws, the first along the smallest footprint
  // The room, along the path of the views; none where it is not known or the thing has no front.
  const Layout* layout = nullptr;

  [[nodiscard]] bool empty() const { return fit_points.empty() || views.empty(); }
};

// At most `max_views` of the object's views are prepared, best supported and spread first.
[[nodiscard]] MeasuredDepth MeasureDepth(const ObjectObservations& object,
                                         bool has_front,
                                         int max_views);

struct PlaceLimits {
  double stretch_min = 0.7;  // factors along each axis relative to the expected size ...
  double stretch_max = 1.4;
  double stretch_sigma = 0.15;  // ... and the deviation of their logarithm
};

struct PlacedShape {
  // Agreement in [0, 1], ScorePlacement, less what a front at a wall costs; 0: nothing agrees.
  double score = 0;
  Placement placement;
};

// The best of what Gauss-Newton iterations from all boxes come to, begun at the expected size and
// at the measured one.
[[nodiscard]] PlacedShape PlaceShape(const CoarseShape& shape,
                                     const Eigen::Vector3d& believed_size_m,
                                     const MeasuredDepth& measured,
                                     const PlaceLimits& limits);

// Agreement of a shape that is placed already.
[[nodiscard]] double ScorePlaced(const CoarseShape& shape,
                                 const Placement& placement,
                                 const MeasuredDepth& measured,
                                 double to_beat = 0);

}  // namespace deepslam::propose
