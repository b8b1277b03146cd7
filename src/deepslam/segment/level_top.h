// Tables: a level top at one height above the ground, and what carries it.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/plane.h"
#include "deepslam/segment/image_pieces.h"
#include "deepslam/segment/region.h"

namespace deepslam::segment {

struct LevelTop {
  double height_m = 0;
  std::vector<Eigen::Vector2d>
      hull_ground_m;  // convex, counter-clockwise, in GroundTangentBasis coordinates
};

// Finds the dominant level surface inside the region and gives its pixels that have no owner to
// `owner`. Nothing when there is none between the heights of seats and bars.
[[nodiscard]] std::optional<LevelTop> ClaimLevelTop(const ImagePieces& pieces,
                                                    const Plane& ground_camera,
                                                    const Region& region,
                                                    int owner,
                                                    const SegmentOptions& options,
                                                    Owners& owners);

// Whether a point lies under the top: lower, and inside its outline on the ground.
[[nodiscard]] bool IsUnder(const LevelTop& top,
                           const Plane& ground_camera,
                           const Eigen::Vector3d& p_camera);

}  // namespace deepslam::segment
