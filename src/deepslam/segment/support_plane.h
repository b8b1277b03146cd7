// Tables: a support plane at one height above the ground.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/segment/image_pieces.h"
#include "deepslam/segment/region.h"
#include "deepslam/segment/top_heights.h"

namespace deepslam::segment {

struct SupportPlane {
  double height_m = 0;
  std::vector<Eigen::Vector2d>
      hull_ground_m;  // convex, counter-clockwise, in GroundTangentBasis coordinates
};

// Finds the layer with the largest outline inside the region that hides what is under it, and gives
// its pixels that have no owner to `owner`. Nothing when there is none between the heights of seats
// and bars. Depth is needed along the rim only: tops of tables often return none elsewhere.
// `heights`: of the pieces.
[[nodiscard]] std::optional<SupportPlane> ClaimSupportPlane(const ImagePieces& pieces,
                                                            std::span<const PieceHeights> heights,
                                                            const PinholeCamera& camera,
                                                            const Plane& ground_camera,
                                                            const Region& region,
                                                            int owner,
                                                            Owners& owners);

}  // namespace deepslam::segment
