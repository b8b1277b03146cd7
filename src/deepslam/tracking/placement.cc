#include "deepslam/tracking/placement.h"

#include "deepslam/alignment/rotation_search.h"
#include "deepslam/tracking/placement_acceptance.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;
using alignment::StartSearch;

// Images of real captures that are laid right correlate like that.
constexpr double kConfidentCorrelation = 0.8;

// World from the camera where it only turned since the reference.
std::optional<Pose3> SearchTurn(const PosedFrame& reference, const PosedFrame& frame) {
  const auto rotation = alignment::SearchRotation(*reference.pyramid, *frame.pyramid);
  if (!rotation) return std::nullopt;
  return reference.world_from_camera * Pose3{*rotation, Eigen::Vector3d::Zero()};
}

}  // namespace

std::optional<Pose3> RecordedPose(const PosedFrame& previous, const PosedFrame& frame) {
  if (!previous.recorded || !frame.recorded) return std::nullopt;
  return previous.world_from_camera * (previous.recorded->Inverse() * *frame.recorded);
}

std::optional<Pose3> PredictedPose(const PathSoFar& path, const PosedFrame& frame) {
  if (const auto recorded = RecordedPose(path.previous, frame)) return recorded;
  const auto motion = path.motion.Predict(frame.clock_s - path.previous.clock_s);
  if (!motion) return std::nullopt;
  return path.previous.world_from_camera * *motion;
}

Starts StartsBehindPrevious(const PathSoFar& path, const PosedFrame& frame) {
  const PosedFrame& previous = path.previous;
  Starts starts;
  if (path.options.motion_prediction) {
    if (const auto predicted = PredictedPose(path, frame))
      starts.world_from_camera.push_back(*predicted);
  }
  starts.world_from_camera.push_back(previous.world_from_camera);
  if (path.options.rotation_search) starts.turned_from = &previous;
  return starts;
}

bool IsConfident(const FrameAlignment& alignment) {
  if (!alignment.ok) return false;
  return alignment.intensity_correlation >= kSameImage ||
         (alignment.inlier_ratio >= kConfidentInlierRatio &&
          alignment.intensity_correlation >= kConfidentCorrelation);
}

FrameAlignment AlignTo(const PathSoFar& path,
                       const PosedFrame& reference,
                       const PosedFrame& frame,
                       const std::vector<Pose3>& starts_world,
                       const StartSearch& search_world) {
  const Pose3 reference_from_world = reference.world_from_camera.Inverse();
  std::vector<Pose3> starts;
  starts.reserve(starts_world.size());
  for (const Pose3& start : starts_world) starts.push_back(reference_from_world * start);
  StartSearch search;
  if (search_world) {
    search = [&]() -> std::optional<Pose3> {
      const std::optional<Pose3> found = search_world();
      return found ? std::optional(reference_from_world * *found) : std::nullopt;
    };
  }
  return alignment::AlignPyramids(*reference.pyramid,
                                  *frame.pyramid,
                                  starts,
                                  path.options.alignment,
                                  path.motion.SigmaOfStart(frame.clock_s - reference.clock_s),
                                  search);
}

FrameAlignment Place(const PathSoFar& path,
                     const PosedFrame& reference,
                     const PosedFrame& last,
                     const PosedFrame& frame,
                     const Starts& starts) {
  StartSearch search_turn;
  if (starts.turned_from != nullptr)
    search_turn = [&] { return SearchTurn(*starts.turned_from, frame); };
  FrameAlignment found = AlignTo(path, reference, frame, starts.world_from_camera, search_turn);
  found.ok = found.ok && IsAcceptable(path, reference, last, frame, found);
  return found;
}

FrameAlignment PlaceByFeatures(const PathSoFar& path,
                               const PosedFrame& reference,
                               const PosedFrame& last,
                               const PosedFrame& frame) {
  if (last.sub_trajectory != reference.sub_trajectory) return {};
  const auto start = path.features != nullptr && *path.features
                         ? (*path.features)(reference.frame, frame.frame)
                         : std::nullopt;
  if (!start) return {};
  const Pose3 world_from_camera = reference.world_from_camera * start->reference_from_frame;
  const FrameAlignment placed = Place(path, reference, last, frame, {{world_from_camera}});
  if (placed.ok) return placed;
  FrameAlignment found = AlignTo(path, reference, frame, {world_from_camera});
  found.ok = IsBorneOutByFeatures(path, reference, last, frame, found, *start);
  return found;
}

}  // namespace deepslam::tracking
