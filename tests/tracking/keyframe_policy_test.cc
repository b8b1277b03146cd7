#include "deepslam/tracking/keyframe_policy.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/angles.h"
#include "support/pose_matchers.h"
#include "tracking/small_path.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;
using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::PoseNear;

Pose3 Moved(double x_m, double turn_deg = 0) {
  return V2t((Vector6d() << x_m, 0, 0, 0, turn_deg * kRadPerDeg, 0).finished());
}

PosedFrame At(const Pose3& world_from_camera, double clock_s = 0) {
  PosedFrame frame;
  frame.world_from_camera = world_from_camera;
  frame.clock_s = clock_s;
  return frame;
}

// What an alignment to the keyframe says that sees nearly all that it sees.
FrameAlignment Near() {
  FrameAlignment alignment;
  alignment.inside_ratio = alignment.overlap_ratio = 0.95;
  return alignment;
}

TEST(IsFarFrom, IsToldByDistanceOrAngleEitherWay) {
  const OdometryOptions options;
  const Pose3 here = Moved(1, 30);
  const double distance_m = options.keyframe_distance_m, angle_deg = options.keyframe_angle_deg;
  for (const Pose3& near : {Pose3{}, Moved(0.9 * distance_m), Moved(0, 0.9 * angle_deg)})
    EXPECT_FALSE(IsFarFrom(here, here * near, options));
  for (const Pose3& far : {Moved(1.1 * distance_m), Moved(0, 1.1 * angle_deg)}) {
    EXPECT_TRUE(IsFarFrom(here, here * far, options));
    EXPECT_TRUE(IsFarFrom(here * far, here, options));
  }
}

TEST(WantsKeyframe, WhereTheFrameIsFarOrSeesTooLittleOfTheKeyframe) {
  const OdometryOptions options;
  const FrameAlignment near = Near();
  const auto wants = [&](const Pose3& place, const FrameAlignment* alignment) {
    return WantsKeyframe(At(Pose3{}), At(place), alignment, options);
  };
  EXPECT_FALSE(wants(Moved(0.01), &near));
  EXPECT_FALSE(wants(Moved(0.01), nullptr));
  EXPECT_TRUE(wants(Moved(2 * options.keyframe_distance_m), &near));
  EXPECT_TRUE(wants(Moved(2 * options.keyframe_distance_m), nullptr));
  FrameAlignment outside = near;
  outside.inside_ratio = 0.9 * options.keyframe_min_overlap;
  EXPECT_TRUE(wants(Moved(0.01), &outside));
  // Holes in the depth leave few common points; half of the overlap is enough then.
  FrameAlignment holes = near;
  holes.overlap_ratio = 0.6 * options.keyframe_min_overlap;
  EXPECT_FALSE(wants(Moved(0.01), &holes));
  holes.overlap_ratio = 0.4 * options.keyframe_min_overlap;
  EXPECT_TRUE(wants(Moved(0.01), &holes));
}

TEST(WantsKeyframe, WhereNothingHasShownTheMotionForLong) {
  FrameAlignment remapped = Near();
  remapped.remapped = true;
  const auto wants = [&](double clock_s, const FrameAlignment& alignment) {
    return WantsKeyframe(At(Pose3{}), At(Pose3{}, clock_s), &alignment, {});
  };
  EXPECT_FALSE(wants(0.3, remapped));
  EXPECT_TRUE(wants(0.7, remapped));
  EXPECT_FALSE(wants(0.7, Near()));
}

}  // namespace
}  // namespace deepslam::tracking
