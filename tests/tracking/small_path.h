// Frames of a rendered room on their way through the tracker, placed where they truly are.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "alignment/box_world.h"
#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/tracking/keyframe_window.h"
#include "deepslam/tracking/placement.h"

namespace deepslam::tracking {

// Twenty frames a second.
inline constexpr double kFrameInterval_s = 0.05;

inline PosedFrame Posed(const testing_support::BoxWorld& world,
                        const Pose3& world_from_camera,
                        int frame,
                        int sub_trajectory = 0) {
  PosedFrame posed;
  posed.frame = FrameIdx{frame};
  posed.time_s = posed.clock_s = kFrameInterval_s * frame;
  posed.pyramid = std::make_shared<const alignment::FramePyramid>(
      alignment::BuildPyramid(testing_support::RenderFrame(
                                  world, world_from_camera, 1.0, static_cast<std::uint64_t>(frame)),
                              testing_support::kSmallCamera,
                              {}));
  posed.world_from_camera = world_from_camera;
  posed.sub_trajectory = sub_trajectory;
  return posed;
}

// A path whose keyframes were tracked without error, and the frame placed last.
struct SmallPath {
  OdometryOptions options;
  KeyframeWindow keyframes{OdometryOptions{}.num_relocalisation_keyframes};
  PosedFrame previous;
  MotionModel motion{true};

  // The last of them is where the camera was.
  void Add(PosedFrame keyframe) {
    MakeReference(keyframe);
    previous = keyframe;
    keyframes.Push(std::move(keyframe));
  }
  [[nodiscard]] PathSoFar SoFar() const { return {options, keyframes, previous, motion}; }
};

}  // namespace deepslam::tracking
