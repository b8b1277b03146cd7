// Which neighbouring pixels of a frame lie on one smooth surface.
#pragma once

#include <cstdint>
#include <optional>

#include "deepslam/core/image.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/segment/point_image.h"
#include "deepslam/segment/segment_objects.h"

namespace deepslam::segment {

// What is said of a pixel and of its neighbours to the left and above. Links have directions, as
// the depth step that joins two pixels depends on the depth of the one it is seen from.
enum LinkBits : std::uint8_t {
  kFromLeft = 1,
  kToLeft = 2,
  kFromAbove = 4,
  kToAbove = 8,
  kHasNormal = 16,
};

struct SmoothLinks {
  Mask bits;        // LinkBits of every pixel
  Mask horizontal;  // 1: surface faces up (needs a ground)
};

// `fx`: of the camera, in pixels.
[[nodiscard]] SmoothLinks FindSmoothLinks(const PointImage& points_camera,
                                          double fx,
                                          const std::optional<Plane>& ground_camera);

}  // namespace deepslam::segment
