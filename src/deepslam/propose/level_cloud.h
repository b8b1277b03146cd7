// All measured points of an object in one upright frame, and what they say about its size.
//
// Level frame: tracking world turned and shifted so that z is up and the ground is z = 0 (without a
// ground: up is the mean of the images set upright, and the lowest points lie at z = 0).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/pose.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::propose {

struct LevelFrame {
  Pose3 level_from_world;
  bool has_ground = false;
};

// From the views' poses and grounds alone; without a ground the height of z = 0 says nothing.
[[nodiscard]] LevelFrame FindLevel(std::span<const ObjectView> views);

// The side of a cell: about the depth noise of structured light at 3 m; larger cells blur legs and
// boards.
inline constexpr float kCloudCell_m = 0.025F;

struct LevelCloud {
  Pose3 level_from_world;
  bool has_ground = false;
  // One point per cell of a raster, of those cells that enough views saw; metres, level
  // frame, raster order.
  std::vector<Eigen::Vector3f> points;
  double mean_distance_m = 0;  // of the points from their cameras
};

// Empty `points` when the views hold too few.
[[nodiscard]] LevelCloud AccumulateLevel(std::span<const ObjectView> views);

// The cloud that came with the object, else made now.
[[nodiscard]] LevelCloud CloudOf(const ObjectObservations& object);

// At most `max_views` views: the best supported one first, then always the one whose direction to
// `center_world` is farthest from those taken, weak support discounted. Ascending indices into
// `views`.
[[nodiscard]] std::vector<std::size_t> ChooseViews(std::span<const ObjectView> views,
                                                   const Eigen::Vector3d& center_world,
                                                   int max_views);

}  // namespace deepslam::propose
