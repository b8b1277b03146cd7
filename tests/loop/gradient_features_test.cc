// Points with descriptors of gradients, as frames that tracking lost are found by.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "deepslam/loop/feature_pose.h"
#include "deepslam/loop/keyframe_features.h"
#include "loop/textured_room.h"
#include "support/pose_matchers.h"

namespace deepslam::loop {
namespace {

using deepslam::testing_support::PoseNear;
using testing_support::kCamera;
using testing_support::Looking;
using testing_support::Photograph;
using testing_support::TexturedRoom;

constexpr int kMostFeatures = 800;
constexpr int kFewestInliers = 20;

// Means along rows, as a camera that turns sees.
Frame Blurred(const Frame& sharp, int reach_px) {
  Frame frame = sharp;
  for (int v = 0; v < sharp.colour.height(); ++v) {
    for (int u = 0; u < sharp.colour.width(); ++u) {
      int sum = 0;
      for (int du = -reach_px; du <= reach_px; ++du)
        sum += sharp.colour(std::clamp(u + du, 0, sharp.colour.width() - 1), v).r;
      const auto grey = static_cast<std::uint8_t>(sum / (2 * reach_px + 1));
      frame.colour(u, v) = {grey, grey, grey};
    }
  }
  return frame;
}

GradientFeatures Extract(const Frame& frame) {
  return ExtractGradientFeatures(frame, kCamera, kMostFeatures);
}

TEST(GradientFeatures, TellTheMotionBetweenTwoViews) {
  const Pose3 from = Looking({0, 0, 1.4}, 0.3);
  const Pose3 to = Looking({0.2, -0.15, 1.3}, 0.45);
  const Frame old_view = Photograph({}, from, 0), new_view = Photograph({}, to, 1);
  const auto pose = PoseFromFeatures(Extract(old_view), Extract(new_view), kFewestInliers);
  ASSERT_TRUE(pose.has_value());
  EXPECT_THAT(pose->old_from_new, PoseNear(from.Inverse() * to, 0.02, 0.6));
}

TEST(GradientFeatures, OutlastBlur) {
  const Pose3 from = Looking({0, 0, 1.4}, 0.3);
  const Pose3 to = Looking({0.06, -0.03, 1.38}, 0.36);
  const Frame old_view = Blurred(Photograph({}, from, 0), 5);
  const Frame new_view = Blurred(Photograph({}, to, 1), 5);
  const auto by_gradients = PoseFromFeatures(Extract(old_view), Extract(new_view), kFewestInliers);
  ASSERT_TRUE(by_gradients.has_value());
  EXPECT_THAT(by_gradients->old_from_new, PoseNear(from.Inverse() * to, 0.03, 1.0));
}

TEST(GradientFeatures, OfAnotherRoomGiveNoPose) {
  TexturedRoom other;
  other.seed = 2;
  const Pose3 at = Looking({0, 0, 1.4}, 0.3);
  const auto pose = PoseFromFeatures(
      Extract(Photograph({}, at, 0)), Extract(Photograph(other, at, 1)), kFewestInliers);
  EXPECT_FALSE(pose.has_value());
}

TEST(GradientFeatures, NothingToSeeGivesNothing) {
  const Frame whole = Photograph({}, Looking({0, 0, 1.4}, 0.3), 7);
  ASSERT_GT(Extract(whole).descriptors.size(), 100U);
  EXPECT_EQ(Extract(whole).keyframe, FrameIdx{7});
  EXPECT_EQ(Extract(whole).descriptors.size(), Extract(whole).points_camera.size());
  Frame frame = whole;
  frame.colour = ColourImage();
  EXPECT_TRUE(Extract(frame).descriptors.empty());
  frame = whole;
  frame.depth_m = DepthImage(kCamera.width / 2, kCamera.height);
  EXPECT_TRUE(Extract(frame).descriptors.empty());
  frame = whole;
  std::fill(frame.depth_m.begin(), frame.depth_m.end(), 0.0F);
  EXPECT_TRUE(Extract(frame).descriptors.empty());
  EXPECT_TRUE(ExtractGradientFeatures(whole, kCamera, 0).descriptors.empty());
  EXPECT_FALSE(PoseFromFeatures(Extract(frame), Extract(whole), kFewestInliers).has_value());
}

TEST(GradientFeatures, AreTheSameEachTime) {
  const Frame frame = Photograph({}, Looking({0, 0, 1.4}, 0.3), 0);
  EXPECT_EQ(Extract(frame).descriptors, Extract(frame).descriptors);
  EXPECT_LE(ExtractGradientFeatures(frame, kCamera, 50).descriptors.size(), 50U);
}

}  // namespace
}  // namespace deepslam::loop
