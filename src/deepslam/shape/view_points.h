// The measured points of one view of an object, with normals.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/object_view.h"

namespace deepslam::shape {

struct ViewPoints {
  std::vector<Eigen::Vector3f> points_camera;   // metres, camera frame of the view
  std::vector<Eigen::Vector3f> normals_camera;  // unit, towards the camera; one per point
};

// The segment's pixels unprojected. Pixels at depth jumps (edges, flying pixels) and those whose
// neighbourhood gives no plane are left out; of the rest at most `max_points`, evenly spread over
// the surface in space. Deterministic. Empty when the view has no usable pixel or its images differ
// in size.
[[nodiscard]] ViewPoints ExtractViewPoints(const ObjectView& view, int max_points);

}  // namespace deepslam::shape
