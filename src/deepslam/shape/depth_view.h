// What a view measured along the ray through a point in space: the one lookup under everything that
// carves with depth. What that says of the point is for each asker to decide.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::shape {

class DepthView {
 public:
  // `view` must outlive the object; its images fit together. `camera_from_frame`: metres.
  DepthView(const ObjectView& view, const Pose3& camera_from_frame);

  struct Reading {
    float z_m = 0;      // of the point, along the camera's axis
    float depth_m = 0;  // measured in its pixel, finite, > 0
    // Of the angle between ray and measured surface; 1 where the neighbourhood gives no surface,
    // not below 0.2, where depth cameras see nothing anyway.
    float cosine = 1;
    bool is_object = false;  // the pixel is of the object's segment
  };
  // Nothing when the point is not before the camera or out of the crop, or nothing was measured.
  [[nodiscard]] std::optional<Reading> At(const Eigen::Vector3f& p_frame) const;

 private:
  const ObjectView* view_;
  Image<float> cosine_;
  Eigen::Matrix3f rotation_;  // camera from frame
  Eigen::Vector3f translation_;
  float fx_, fy_, cx_, cy_;
};

}  // namespace deepslam::shape
