#include "deepslam/mapping/recorded_edges.h"

#include <algorithm>
#include <optional>

#include "deepslam/core/angles.h"
#include "deepslam/core/order_statistics.h"

namespace deepslam::mapping {
namespace {

// The median length of a vector of three normal numbers of deviation 1 (Maxwell's distribution).
constexpr double kMedianLength = 1.538;
constexpr std::size_t kFewestMotions = 8;  // their median is then known to 20 %
// No recorder is better from keyframe to keyframe.
constexpr RecordedNoise kLeastNoise{0.002, 0.1 * kRadPerDeg};

struct Pair {
  const TrackedFrame* before = nullptr;
  const TrackedFrame* after = nullptr;
  Pose3 before_from_after;  // by the recorder
};

std::vector<Pair> PairsOf(const Odometry& tracked, const tracking::RecordedPoses& recorded) {
  std::vector<Pair> pairs;
  for (std::size_t k = 1; k < tracked.keyframes.size(); ++k) {
    const FrameIdx before = tracked.keyframes[k - 1];
    const FrameIdx after = tracked.keyframes[k];
    const std::optional<Pose3> from = recorded(before);
    const std::optional<Pose3> to = recorded(after);
    if (from && to)
      pairs.push_back({&tracked.at(before), &tracked.at(after), from->Inverse() * *to});
  }
  return pairs;
}

}  // namespace

RecordedNoise EstimateRecordedNoise(const Odometry& tracked,
                                    const tracking::RecordedPoses& recorded,
                                    const RecordedNoise& fallback) {
  std::vector<double> off_m, off_rad;
  for (const Pair& pair : PairsOf(tracked, recorded)) {
    if (pair.before->status != TrackingStatus::kTracked ||
        pair.after->status != TrackingStatus::kTracked) {
      continue;
    }
    const Pose3 motion = pair.before->world_from_camera.Inverse() * pair.after->world_from_camera;
    const Pose3 off = pair.before_from_after.Inverse() * motion;
    off_m.push_back(off.translation_m.norm());
    off_rad.push_back(RotationAngle(off.rotation));
  }
  if (off_m.size() < kFewestMotions) return fallback;
  return {std::max(kLeastNoise.translation_m, Median(off_m) / kMedianLength),
          std::max(kLeastNoise.rotation_rad, Median(off_rad) / kMedianLength)};
}

std::vector<RelativePose> RecordedEdges(const Odometry& tracked,
                                        const tracking::RecordedPoses& recorded,
                                        const RecordedNoise& noise) {
  Vector6d information;
  information << Eigen::Vector3d::Constant(1 / (noise.translation_m * noise.translation_m)),
      Eigen::Vector3d::Constant(1 / (noise.rotation_rad * noise.rotation_rad));
  std::vector<RelativePose> edges;
  for (const Pair& pair : PairsOf(tracked, recorded)) {
    edges.push_back({pair.before->frame,
                     pair.after->frame,
                     pair.before_from_after,
                     Matrix6d(information.asDiagonal()),
                     false});
  }
  return edges;
}

}  // namespace deepslam::mapping
