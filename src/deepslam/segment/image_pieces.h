// A frame's depth cut into pieces: connected pixels of one smooth surface. The atoms of
// segmentation.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/segment/point_image.h"
#include "deepslam/segment/segment_objects.h"

namespace deepslam::segment {

// Points and their pieces. Pixels without usable depth and pixels on the ground have point z = 0
// and piece -1.
struct ImagePieces {
  PointImage points_camera;
  Image<float> height_m;        // above the ground; 0 where no ground is known
  Mask horizontal;              // 1: surface faces up (needs a ground)
  Mask beyond;                  // 1: the ray was seen to go on to the ground or out of reach
  Image<std::int32_t> piece;    // piece of each pixel, -1 = none
  std::vector<int> num_pixels;  // per piece
  bool has_ground = false;
};

[[nodiscard]] ImagePieces CutIntoPieces(const DepthImage& depth_m,
                                        const PinholeCamera& camera,
                                        const std::optional<Plane>& ground_camera,
                                        const SegmentOptions& options);

// Depth step that still joins neighbouring pixels at this depth.
[[nodiscard]] inline double JumpAt(double depth_m) {
  return SegmentOptions::kJump_m + SegmentOptions::kJump_per_m2 * depth_m * depth_m;
}

}  // namespace deepslam::segment
