#include "deepslam/tracking/keyframe_window.h"

#include <vector>

#include <gtest/gtest.h>

#include "deepslam/alignment/reference_pixels.h"
#include "support/pose_matchers.h"
#include "tracking/small_path.h"

namespace deepslam::tracking {
namespace {

using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::PoseNear;

std::vector<int> FramesOf(const KeyframeWindow& window) {
  std::vector<int> frames;
  for (const PosedFrame& keyframe : window.all()) frames.push_back(keyframe.frame.value);
  return frames;
}

// Frames 0, 10, 20 of sub-trajectories 0, 1, 1.
KeyframeWindow Three(int most = 12) {
  const std::vector<Pose3> truth = Arc(3);
  KeyframeWindow window(most);
  for (int k = 0; k < 3; ++k) {
    window.Push(
        Posed(BoxWorld::Furnished(), truth[static_cast<std::size_t>(k)], 10 * k, k > 0 ? 1 : 0));
  }
  return window;
}

TEST(KeyframeWindow, KeepsTheLastOnesAsReferences) {
  const KeyframeWindow window = Three(2);
  EXPECT_EQ(FramesOf(window), (std::vector<int>{10, 20}));
  EXPECT_EQ(window.last().frame, FrameIdx{20});
  for (const PosedFrame& keyframe : window.all())
    EXPECT_TRUE(alignment::IsReference(*keyframe.pyramid));
}

TEST(KeyframeWindow, JoinsASubTrajectoryToAnEarlierOneAndMovesItAlone) {
  KeyframeWindow window = Three();
  const std::vector<Pose3> truth = Arc(3);
  const Pose3 motion = V2t((Vector6d() << 1, 0, 0, 0, 0, 0.5).finished());
  EXPECT_EQ(window.PlacedOf(1).size(), 2U);
  window.Join(1, 0, motion);
  EXPECT_TRUE(window.PlacedOf(1).empty());
  const auto placed = window.PlacedOf(0);
  ASSERT_EQ(placed.size(), 3U);
  EXPECT_THAT(placed[0].world_from_camera, PoseNear(truth[0], 1e-12, 1e-9));
  EXPECT_THAT(placed[2].world_from_camera, PoseNear(motion * truth[2], 1e-12, 1e-9));
}

TEST(KeyframeWindow, GivesUpAllFromAFrameOn) {
  KeyframeWindow window = Three();
  window.GiveUpFrom(FrameIdx{10});
  EXPECT_EQ(FramesOf(window), std::vector<int>{0});
}

}  // namespace
}  // namespace deepslam::tracking
