#include "deepslam/mapping/feature_starts.h"

#include <vector>

#include <gtest/gtest.h>

#include "mapping/walked_room.h"
#include "support/pose_matchers.h"

namespace deepslam::mapping {
namespace {

using deepslam::testing_support::PoseNear;

// A start from where alignment, which looks 0.3 m far for what belongs together, finds the place.
constexpr double kStart_m = 0.1;
constexpr double kStart_deg = 2;

std::vector<Pose3> Places() {
  return {Looking({0, 0, 1.4}, 0.3),
          Looking({0.15, -0.1, 1.35}, 0.5),
          Looking({0, 0, 1.4}, 0.3 + 3),  // behind the camera's back
          Looking({0.05, 0, 1.4}, 0.35)};
}

TEST(FeaturePlaces, AFrameIsFoundAtOneThatShowsTheSame) {
  const std::vector<Pose3> truth = Places();
  const dataset::MemoryFrameSource frames = SourceOf(FramesAlong({}, truth));
  FeaturePlaces places(frames, 2);  // fewer than are asked about
  for (const int reference : {0, 3, 0}) {
    const auto found = places.Find(FrameIdx{reference}, FrameIdx{1});
    ASSERT_TRUE(found.has_value()) << reference;
    EXPECT_THAT(
        found->reference_from_frame,
        PoseNear(
            truth[static_cast<std::size_t>(reference)].Inverse() * truth[1], kStart_m, kStart_deg));
    EXPECT_GE(found->num_inliers, 20);
  }
  EXPECT_FALSE(places.Find(FrameIdx{2}, FrameIdx{1}).has_value());
}

TEST(FeaturePlaces, WhatCannotBeReadIsFoundNowhere) {
  std::vector<Frame> images = FramesAlong({}, Places());
  MakeUnreadable(images[1]);
  const dataset::MemoryFrameSource frames = SourceOf(std::move(images));
  FeaturePlaces places(frames, 4);
  EXPECT_FALSE(places.Find(FrameIdx{0}, FrameIdx{1}).has_value());
  EXPECT_FALSE(places.Find(FrameIdx{1}, FrameIdx{0}).has_value());
  EXPECT_TRUE(places.Find(FrameIdx{0}, FrameIdx{3}).has_value());
}

}  // namespace
}  // namespace deepslam::mapping
