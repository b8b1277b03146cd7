#include "deepslam/tracking/keyframe_policy.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "deepslam/core/angles.h"
#include "deepslam/tracking/placement.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;

// Overlap that a skip edge needs: below, it adds little and fails often.
constexpr double kSkipEdgeOverlap = 0.4;
// Holes in both depth images leave few common points between frames that see the same place: only
// this share of the asked overlap makes a keyframe of such a frame.
constexpr double kFewCommonPoints = 0.5;
// A camera whose motion nothing shows may be anywhere after a while, also where it would see
// something again: it is compared with what it saw lately.
constexpr double kLongUnobserved_s = 0.5;

}  // namespace

bool IsFarFrom(const Pose3& world_from_keyframe,
               const Pose3& world_from_camera,
               const OdometryOptions& options) {
  const Pose3 moved = world_from_keyframe.Inverse() * world_from_camera;
  return moved.translation_m.norm() > options.keyframe_distance_m ||
         RotationAngle(moved.rotation) > options.keyframe_angle_deg * kRadPerDeg;
}

bool WantsKeyframe(const PosedFrame& keyframe,
                   const PosedFrame& frame,
                   const FrameAlignment* to_keyframe,
                   const OdometryOptions& options) {
  if (to_keyframe != nullptr && to_keyframe->remapped &&
      frame.clock_s - keyframe.clock_s > kLongUnobserved_s)
    return true;
  if (IsFarFrom(keyframe.world_from_camera, frame.world_from_camera, options)) return true;
  return to_keyframe != nullptr &&
         (to_keyframe->inside_ratio < options.keyframe_min_overlap ||
          to_keyframe->overlap_ratio < kFewCommonPoints * options.keyframe_min_overlap);
}

JointMeasurement Joined(const MeasuredPose& a, const MeasuredPose& b) {
  const Vector6d difference = T2v(a.world_from_camera.Inverse() * b.world_from_camera);
  const Matrix6d covariance = a.information.inverse() + b.information.inverse();
  const double birge = std::max(1.0, difference.dot(covariance.ldlt().solve(difference)) / 6);
  const Matrix6d joint = a.information + b.information;
  const Vector6d step = joint.ldlt().solve(b.information * difference);
  return {a.information / birge, b.information / birge, a.world_from_camera * V2t(step)};
}

std::optional<SkipEdge> MeasureSkipEdge(const KeyframeWindow& keyframes,
                                        const PosedFrame& next,
                                        const FrameAlignment& to_last,
                                        const OdometryOptions& options) {
  const PosedFrame* const before_last = keyframes.before_last();
  if (!options.skip_edges || before_last == nullptr) return std::nullopt;
  const PosedFrame& last = keyframes.last();
  if (before_last->sub_trajectory != next.sub_trajectory || last.remapped) return std::nullopt;
  const FrameAlignment skip =
      alignment::RefineAlignment(*before_last->pyramid,
                                 *next.pyramid,
                                 before_last->world_from_camera.Inverse() * next.world_from_camera,
                                 options.alignment);
  if (!skip.ok) return std::nullopt;
  if (skip.inside_ratio < kSkipEdgeOverlap || skip.inlier_ratio < kConfidentInlierRatio)
    return std::nullopt;
  const MeasuredPose by_last{last.world_from_camera * to_last.i_from_j, to_last.information};
  const MeasuredPose by_skip{before_last->world_from_camera * skip.i_from_j, skip.information};
  return SkipEdge{skip, Joined(by_last, by_skip)};
}

}  // namespace deepslam::tracking
