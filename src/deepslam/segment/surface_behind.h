// What is seen through an object that returned no depth itself.
#pragma once

#include <optional>
#include <span>

#include "deepslam/core/image.h"
#include "deepslam/core/quarter_turn.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/segment/connect.h"
#include "deepslam/segment/region.h"

namespace deepslam::segment {

// Whether the points lie on one upright plane that goes on above the box and beside it: the wall
// seen through the frame of a dark chair's back, which stands nearer. Above and beside as the image
// shows them that `upright` has turned. False without a ground, which tells what is upright, and
// for points that are no plane.
[[nodiscard]] bool IsSurfaceBehind(std::span<const PixelPoint> points,
                                   const Region& region,
                                   const DepthImage& depth_m,
                                   const PinholeCamera& camera,
                                   const std::optional<Plane>& ground_camera,
                                   QuarterTurn upright);

}  // namespace deepslam::segment
