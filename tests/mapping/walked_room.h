// A camera that walks through a textured room: frames, truth, and what tracking would say of it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "deepslam/core/random.h"
#include "deepslam/dataset/memory_frame_source.h"
#include "deepslam/scene/edge_store.h"
#include "deepslam/scene/trajectory.h"
#include "loop/textured_room.h"
#include "support/recording_progress.h"

namespace deepslam::mapping {

using ::deepslam::testing_support::RecordingProgress;
using loop::testing_support::kCamera;
using loop::testing_support::Looking;
using loop::testing_support::Photograph;
using loop::testing_support::TexturedRoom;

inline std::vector<Frame> FramesAlong(const TexturedRoom& room, const std::vector<Pose3>& truth) {
  std::vector<Frame> frames;
  for (const Pose3& pose : truth) {
    const auto idx = static_cast<int>(frames.size());
    frames.push_back(Photograph(room, pose, idx));
    frames.back().time_s = 0.1 * idx;
  }
  return frames;
}

inline dataset::MemoryFrameSource SourceOf(std::vector<Frame> frames) {
  return {kCamera, std::move(frames)};
}

// Reads as an error.
inline void MakeUnreadable(Frame& frame) {
  frame.colour = ColourImage();
  frame.depth_m = DepthImage();
}

inline EdgeStoreFactory InMemory() {
  return [] { return std::make_shared<MemoryEdgeStore>(); };
}

// One standard deviation of a measurement between keyframes.
inline constexpr double kNoiseM = 0.004;
inline constexpr double kNoiseRad = 0.002;

inline Pose3 Disturbed(const Pose3& pose, Random& random, double times = 1) {
  Vector6d error;
  for (int k = 0; k < 6; ++k) error[k] = times * (k < 3 ? kNoiseM : kNoiseRad) * random.Normal();
  return pose * V2t(error);
}

// As the noise is.
inline Matrix6d NoiseInformation() {
  Vector6d information;
  information << Eigen::Vector3d::Constant(1 / (kNoiseM * kNoiseM)),
      Eigen::Vector3d::Constant(1 / (kNoiseRad * kNoiseRad));
  return information.asDiagonal();
}

// Every frame a keyframe, each registered to the one before it.
inline Odometry TrackedAs(const std::vector<Pose3>& world_from_camera) {
  Odometry odometry = loop::testing_support::Tracked(world_from_camera);
  for (RelativePose& edge : odometry.edges) edge.information = NoiseInformation();
  return odometry;
}

// The path that noisy measurements from keyframe to keyframe make.
inline std::vector<Pose3> Drifting(const std::vector<Pose3>& truth, double times = 1) {
  Random random(11, "drift", 0);
  std::vector<Pose3> tracked = {truth.front()};
  for (std::size_t k = 1; k < truth.size(); ++k) {
    tracked.push_back(tracked.back() * Disturbed(truth[k - 1].Inverse() * truth[k], random, times));
  }
  return tracked;
}

// The largest distance of a camera from where it was, both paths from their first camera, m.
inline double LargestError_m(const std::vector<TrackedFrame>& frames,
                             const std::vector<Pose3>& truth) {
  double largest = 0;
  const Pose3 tracked_from_first = frames.front().world_from_camera.Inverse();
  const Pose3 truth_from_first = truth.front().Inverse();
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Eigen::Vector3d is = (tracked_from_first * frames[k].world_from_camera).translation_m;
    const Eigen::Vector3d was = (truth_from_first * truth[k]).translation_m;
    largest = std::max(largest, (is - was).norm());
  }
  return largest;
}

}  // namespace deepslam::mapping
