// Error of an estimated trajectory against a true one: ATE and RPE, rigid alignment, as `evo`
// measures them.
#pragma once

#include <string_view>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/geometry/pose.h"

namespace deepslam {

inline constexpr std::string_view kTrajectoryProtocol =
    "evo-ate-rpe: SE(3) alignment of positions by least squares, no scale; ATE of positions, RPE "
    "of translation and rotation angle";

struct TimedPose {
  double time_s = 0;
  Pose3 world_from_camera;
};

struct TrajectoryErrorOptions {
  double max_time_difference_s = 0.01;  // between an estimated pose and its true one
  int rpe_delta = 1;                    // scored frames between the two ends of a relative pose
};
void Describe(OptionsVisitor& visitor, TrajectoryErrorOptions& options);

struct ErrorStatistics {
  double rmse = 0;
  double mean = 0;
  double median = 0;  // mean of the two middle values where their number is even
  double max = 0;
};

// Figures about few frames say little: num_scored and num_frames always go with them.
struct TrajectoryError {
  int num_frames = 0;         // in the estimate
  int num_scored = 0;         // with a true pose at their time
  Pose3 truth_from_estimate;  // the rigid motion (no scale) that aligns the estimated positions,
                              // least squares
  ErrorStatistics ate_m;      // distance of aligned positions
  int num_relative = 0;       // pairs of consecutive scored frames, `rpe_delta` apart
  ErrorStatistics rpe_m;      // translation of (true relative pose)^-1 * (estimated relative pose)
  ErrorStatistics rpe_deg;    // its rotation angle
  std::vector<int> scored;    // indices into the estimate
  std::vector<double> position_error_m;  // per scored frame
};

// Poses of both lists are paired by nearest time, each used once at most; the lists may be in any
// order. Where the times of both fall back alike (core/clock_segments.h), poses are paired within
// their segment. Errors: a list is empty, holds a value that is not finite, or fewer than three
// pairs.
Result<TrajectoryError> ComputeTrajectoryError(std::vector<TimedPose> estimate,
                                               std::vector<TimedPose> truth,
                                               const TrajectoryErrorOptions& options);

// b_from_a of least squares for paired points, rotation and translation only (Umeyama 1991, c = 1);
// exactly the identity for equal points.
Pose3 AlignRigidly(const std::vector<Eigen::Vector3d>& points_a,
                   const std::vector<Eigen::Vector3d>& points_b);

}  // namespace deepslam
