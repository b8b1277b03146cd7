// Where a candidate's model stands: one registration per (candidate, view), one scale per
// candidate.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/similarity.h"

namespace deepslam {

struct ViewRegistration {
  DetectionId view;
  FrameIdx frame;
  bool ok = false;  // false: this view tells nothing about the pose; `reason` says why
  std::string reason;
  // z_io of the paper: object-to-camera in metres (object axes, origin at the model's centre), the
  // inverse of the registered T_oi with the candidate's scale taken out.
  Pose3 camera_from_object;
  double rmse_m = 0;  // point-to-plane over inliers
  double inlier_share = 0;
  // Information of t2v(camera_from_object^-1 * true) conditioned on the scale; (translation m;
  // rotation rad).
  Matrix6d information = Matrix6d::Zero();
  bool yaw_free = false;  // rotation about the model's vertical is not observable (round table)
};

struct CandidateRegistration {
  CandidateId candidate;
  bool ok = false;  // false: no view could be registered
  std::string reason;
  double scale_m = 0;       // metres per object unit, common to all views
  Pose3 world_from_object;  // consensus of the views through the tracked cameras (tracking world)
  std::vector<ViewRegistration> views;  // ascending frames
};

// By the view's own registration where it has one, else by the joint pose. `index` of the view
// among the object's views, whose order registration keeps.
[[nodiscard]] inline Pose3 CameraFromObject(const CandidateRegistration& registration,
                                            DetectionId view,
                                            std::size_t index,
                                            const Pose3& world_from_camera) {
  if (index < registration.views.size() && registration.views[index].ok &&
      registration.views[index].view == view)
    return registration.views[index].camera_from_object;
  return world_from_camera.Inverse() * registration.world_from_object;
}

}  // namespace deepslam
