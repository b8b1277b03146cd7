// How well one view fixes the pose of a placed model (the paper's H = J^T J at the solution).
#pragma once

#include "deepslam/geometry/pose.h"
#include "deepslam/registration/measured_view.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::registration {

struct ViewFit {
  int num_inliers = 0;
  double inlier_share = 0;                  // of the view's points
  double rmse_m = 0;                        // point-to-plane over inliers
  Matrix6d information = Matrix6d::Zero();  // as ViewRegistration::information
  double yaw_sigma_rad = 0;  // of the rotation about the model's vertical, all else free
};

// Fit of a view at a pose with given scale, correspondences fixed, points within `radius_m` of the
// surface.
//
// The Jacobian of the point-to-plane residuals is taken in the camera frame, where points and noise
// live, and carried to t2v(camera_from_object^-1 * true) by the adjoint: H_o = Ad^T H_c Ad with Ad
// = Adjoint(camera_from_object). Scaled by 1 / sigma^2, sigma the larger of sensor noise and the
// residuals' own rms (a model is never quite the object), and by the view's patch_share, since
// residuals of one patch err together. Conditioned on the scale. A floor of 1 / (1 m)^2, 1 / (10
// deg)^2 for tilting and 1 / (180 deg)^2 for yaw keeps it positive definite and its weak directions
// weak. For a round model (`is_round`) yaw keeps the floor only: what its voxel steps seem to tell
// is not real.
[[nodiscard]] ViewFit FitOfView(const shape::ShapeModel& model,
                                const MeasuredView& view,
                                const Pose3& camera_from_object,
                                double scale_m,
                                double radius_m,
                                bool is_round);

// Whether the model covers itself however it is turned about its vertical: at each of the tested
// angles at least `share` of its surface lies within 1.5 voxels of the surface.
[[nodiscard]] bool IsRound(const shape::ShapeModel& model, double share);

}  // namespace deepslam::registration
