// Planes in thinned points: search within permissible orientations, and robust refinement with
// information.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/angles.h"
#include "deepslam/core/quarter_turn.h"
#include "deepslam/core/random.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/ground/ground_plane.h"
#include "deepslam/ground/ground_points.h"

namespace deepslam::ground {

// A plane refined farther from its prediction than this has gone to another surface.
inline constexpr double kMaxTurnRad = 6 * kRadPerDeg;
inline constexpr double kMaxShiftM = 0.08;  // m: twice what points may lie off the predicted plane

// Cosine between a plane's normal and those of its points, where it is known: 20 degrees.
inline constexpr double kReidentifyCosine = 0.94;
inline constexpr int kMinPlanePoints = 30;  // fewer make no plane

struct PlaneCandidate {
  Plane plane_camera;                                         // normal up
  Eigen::Vector3d centroid_camera = Eigen::Vector3d::Zero();  // of the inliers
  double share = 0;                                           // inliers of all points of the frame
};

// True when a camera that sees the plane so could see the ground so: orientation only. `upright` is
// the turn that sets the camera's pictures upright.
[[nodiscard]] bool PermissibleOrientation(const Plane& plane_camera, QuarterTurn upright);

// The largest planes of permissible orientation, largest first, by sequential RANSAC.
[[nodiscard]] std::vector<PlaneCandidate> FindPlanes(const GroundPoints& points,
                                                     QuarterTurn upright,
                                                     Random& random);

// Of the plane, by the points that lie on it.
[[nodiscard]] double CoveredAreaM2(const GroundPoints& points,
                                   const PinholeCamera& camera,
                                   const Plane& plane_camera);

// Of a plane with these standard deviations, as GroundObservation has it.
[[nodiscard]] Eigen::Matrix3d InformationOf(double angle_rad, double distance_m);

struct PlaneRefinement {
  Plane plane_camera;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  // as GroundObservation
  int num_inliers = 0;                                        // points
  double inlier_share = 0;                                    // of the frame's points
  double area_m2 = 0;                                         // covered by the inliers
};

// Re-identifies the plane's points near the predicted plane and fits them by iteratively reweighted
// least squares (Tukey). Information: Hessian of n . p + d on (two tangent directions, d), each
// residual scaled by the depth noise along the normal, divided by the number of thinned points that
// share one depth error (the sensor matches blocks of about 9 x 9 pixels), with the systematic
// errors of the options added to the covariance. Nothing when too few points.
[[nodiscard]] std::optional<PlaneRefinement> RefinePlane(const GroundPoints& points,
                                                         const PinholeCamera& camera,
                                                         const Plane& predicted_camera);

// The plane turned and shifted by (a, b, d) along its tangent basis.
[[nodiscard]] Plane Perturbed(const Plane& plane, const Eigen::Vector3d& tangent_and_distance);

}  // namespace deepslam::ground
