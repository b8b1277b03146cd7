#include "deepslam/tracking/placement.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "deepslam/alignment/rotation_search.h"
#include "deepslam/core/angles.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/tracking/placement_acceptance.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;
using alignment::OtherStarts;

// Images of real captures that are laid right correlate like that; below this and
// kConfidentInlierRatio, other minima are looked for.
constexpr double kConfidentCorrelation = 0.8;
// Successive images correlate like that where they are laid right, however poor their depth is;
// laid elsewhere, they differ by parallax.
constexpr double kSameImage = 0.95;
// About the scene in front of the camera, to each side and up and down.
constexpr std::array<double, 4> kTurnsDeg = {-18, -9, 9, 18};

double MedianDepthM(const alignment::PyramidLevel& level) {
  std::vector<float> depths;
  std::ranges::copy_if(level.depth_m, std::back_inserter(depths), [](float z) { return z > 0; });
  if (depths.empty()) return 1.0;
  return static_cast<double>(Median(depths));
}

// Camera motions about the point in front of the camera: they leave the image in place, so that
// neither prediction nor image-based search finds them, and are what a camera does that is carried
// round an object.
std::vector<Pose3> Orbits(double distance_m) {
  std::vector<Pose3> orbits;
  const Eigen::Vector3d centre(0, 0, distance_m);
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 0, 0)}) {
    for (const double turn_deg : kTurnsDeg) {
      const Eigen::Quaterniond rotation = RotationFromVector(turn_deg * kRadPerDeg * axis);
      orbits.push_back({rotation, centre - rotation * centre});
    }
  }
  return orbits;
}

// Each start, and each orbit of each start.
std::vector<Pose3> WithOrbits(std::vector<Pose3> starts, const PosedFrame& frame) {
  const std::vector<Pose3> orbits = Orbits(MedianDepthM(frame.pyramid->levels.back()));
  const std::size_t num_starts = starts.size();
  for (std::size_t k = 0; k < num_starts; ++k) {
    for (const Pose3& orbit : orbits) starts.push_back(starts[k] * orbit);
  }
  return starts;
}

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
                       const OtherStarts& others) {
  const Pose3 reference_from_world = reference.world_from_camera.Inverse();
  std::vector<Pose3> starts;
  starts.reserve(starts_world.size());
  for (const Pose3& start : starts_world) starts.push_back(reference_from_world * start);
  const auto search = [&]() -> std::optional<Pose3> {
    if (!others.search) return std::nullopt;
    const std::optional<Pose3> found = others.search();
    return found ? std::optional(reference_from_world * *found) : std::nullopt;
  };
  return alignment::AlignPyramids(*reference.pyramid,
                                  *frame.pyramid,
                                  starts,
                                  path.options.alignment,
                                  path.motion.SigmaOfStart(frame.clock_s - reference.clock_s),
                                  {search, others.always});
}

FrameAlignment Place(const PathSoFar& path,
                     const PosedFrame& reference,
                     const PosedFrame& last,
                     const PosedFrame& frame,
                     Starts starts) {
  std::vector<Pose3>& starts_world = starts.world_from_camera;
  const auto search_turn = [&]() -> std::optional<Pose3> {
    if (starts.turned_from == nullptr) return std::nullopt;
    const auto found = SearchTurn(*std::exchange(starts.turned_from, nullptr), frame);
    if (found) starts_world.push_back(*found);
    return found;
  };
  const auto align = [&](const OtherStarts& others) {
    FrameAlignment found = AlignTo(path, reference, frame, starts_world, others);
    found.ok = found.ok && IsAcceptable(path, reference, last, frame, found);
    return found;
  };
  const FrameAlignment first = align({search_turn});
  if (!path.options.wide_search || IsConfident(first)) return first;
  search_turn();
  starts_world = WithOrbits(std::move(starts_world), frame);
  const FrameAlignment second = align({.search = {}, .always = true});
  const auto support_of = [&](const FrameAlignment& found) {
    return alignment::Support(
        *reference.pyramid, *frame.pyramid, found.i_from_j, path.options.alignment);
  };
  const bool better = second.ok == first.ok ? support_of(second) > support_of(first) : second.ok;
  return better ? second : first;
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
