// A floor of which each frame shows little: beyond a table that fills the pictures, between legs.
//
// Table tops and seats say where up is. Against that direction patches too small for a plane of
// their own are told from chance, and all frames together say which level is the lowest.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/camera.h"
#include "deepslam/ground/ground_points.h"
#include "deepslam/ground/level_search.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::ground {

struct FloorPatch {
  std::size_t keyframe = 0;   // position in the list of keyframes
  double height_m = 0;        // along the vertical, tracking world
  double below_camera_m = 0;  // along the vertical
  double area_m2 = 0;
  int num_points = 0;
};

// The lowest surface of a keyframe's points that faces up and covers a square of 22 cm; which
// keyframe it is of, and its height in the world, are the caller's to set. Nothing where there is
// none.
[[nodiscard]] std::optional<FloorPatch> LowestPatch(const GroundPoints& points,
                                                    const PinholeCamera& camera,
                                                    const Eigen::Vector3d& up_camera);

struct PatchLevel {
  double height_m = 0;               // median of the patches
  std::vector<std::size_t> patches;  // ascending
};

// The lowest level that patches of several keyframes agree on. Nothing where something lies below
// it (`samples`), or where cameras were lower above it than hands hold them: what they saw is a
// seat or a table top then.
[[nodiscard]] std::optional<PatchLevel> FindLowestLevel(std::span<const FloorPatch> patches,
                                                        std::span<const KeyframeSample> samples,
                                                        const Eigen::Vector3d& up_world,
                                                        const GroundOptions& options);

// A level plane at that height, observed by the keyframes of its patches.
[[nodiscard]] Ground GroundOf(const PatchLevel& level,
                              std::span<const FloorPatch> patches,
                              std::span<const TrackedFrame> keyframes,
                              const Eigen::Vector3d& up_world);

}  // namespace deepslam::ground
