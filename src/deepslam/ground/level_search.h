// Which of the horizontal planes seen over a whole capture is the ground.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/ground/ground_plane.h"

namespace deepslam::ground {

struct PlaneSighting {
  std::size_t keyframe = 0;  // position in the list of keyframes
  Plane plane_camera;
  Plane plane_world;
  Eigen::Vector3d centroid_world = Eigen::Vector3d::Zero();
  double camera_height_m = 0;  // of the camera that saw it
  double share = 0;            // of that keyframe's points
};

struct KeyframeSample {
  std::vector<Eigen::Vector3f> points_world;  // a few hundred, evenly over the image
};

// The direction most plane area agrees on, tracking world: floor, table tops and shelves all vote
// for it. Nothing without sightings.
[[nodiscard]] std::optional<Eigen::Vector3d> VerticalDirection(
    std::span<const PlaneSighting> sightings);

// Of all points, those lower than this along `up_world`.
[[nodiscard]] double ShareBelow(std::span<const KeyframeSample> samples,
                                const Eigen::Vector3d& up_world,
                                double height_m);

// Index of the sighting to start from: the largest one of the lowest level. Nothing when no plane
// can be the ground.
[[nodiscard]] std::optional<std::size_t> FindGroundSighting(
    std::span<const PlaneSighting> sightings,
    std::span<const KeyframeSample> samples,
    const GroundOptions& options);

}  // namespace deepslam::ground
