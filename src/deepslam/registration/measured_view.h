// A view made ready for registration: the object's points in space, and what the rest of the crop
// says about where the object cannot be. Made once per object, used by all its candidates.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::registration {

struct PixelIndex {
  std::int16_t u = -1, v = -1;
};

struct MeasuredView {
  DetectionId view;
  FrameIdx frame;
  // Of the object's segment, camera frame, metres; normals are unit and look towards the camera.
  // Points without a usable normal or with a non-finite coordinate are left out.
  std::vector<Eigen::Vector3f> points_camera;
  std::vector<Eigen::Vector3f> normals_camera;
  std::vector<float> sigmas_m;  // depth noise of each point, metres
  Eigen::Vector3d centroid_camera = Eigen::Vector3d::Zero();
  Eigen::Vector3d up_camera = -Eigen::Vector3d::UnitY();  // unit
  // Consensus of all views; nothing when none saw a ground: up_camera is then a guess from how
  // cameras are held.
  std::optional<Plane> ground_world;
  Pose3 world_from_camera;
  // Residuals within one patch of the surface are one measurement: neighbouring pixels err
  // together, by the sensor's pattern and by every difference between model and object. patch_share
  // = patches the points fall into / points.
  double patch_m = 0.05;
  double patch_share = 0;
  bool touches_border = false;

  // The crop, `reduction` times smaller (nearest pixel, so that depth edges stay).
  PinholeCamera camera;
  DepthImage depth_m;
  Mask mask;
  // Normal of the measured surface towards the camera; zero where depth is missing or jumps.
  Image<Eigen::Vector3f> normals;
  // The object pixel nearest to each pixel; -1 everywhere when the mask is empty.
  Image<PixelIndex> nearest_object_pixel;

  [[nodiscard]] bool empty() const { return points_camera.empty(); }
};

// Keeps the order of `views`. Points that most of the other views seeing them count to something
// else are left out: masks err, but rarely all at the same place. Views whose images do not fit
// together, or whose pose or camera is not finite, come back empty. `max_points` per view; crops
// are reduced until their longer side is at most `max_side_px`.
[[nodiscard]] std::vector<MeasuredView> PrepareViews(std::span<const ObjectView> views,
                                                     int max_points = 400,
                                                     int max_side_px = 96,
                                                     double patch_m = 0.05);

}  // namespace deepslam::registration
