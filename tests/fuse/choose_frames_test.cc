#include "deepslam/fuse/choose_frames.h"

#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::fuse {
namespace {

// A camera that moves and turns by so much from each frame to the next; frame 0 is the keyframe.
std::vector<TrackedFrame> Path(int num_frames, double step_m, double step_deg) {
  std::vector<TrackedFrame> path;
  for (int n = 0; n < num_frames; ++n) {
    TrackedFrame frame;
    frame.frame = FrameIdx{n};
    frame.keyframe = FrameIdx{0};
    frame.world_from_camera.translation_m.x() = n * step_m;
    frame.world_from_camera.rotation = Eigen::Quaterniond(
        Eigen::AngleAxisd(n * step_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitY()));
    path.push_back(frame);
  }
  return path;
}

std::vector<int> Chosen(const std::vector<TrackedFrame>& path, const FrameChoice& options) {
  std::vector<int> chosen;
  for (const FrameIdx frame : FramesToFuse(path, options)) chosen.push_back(frame.value);
  return chosen;
}

TEST(FramesToFuse, TakesWhatMovedOrTurnedFarEnough) {
  const FrameChoice options{0.1, 5, 1000};
  EXPECT_EQ(Chosen(Path(10, 0.04, 0), options), (std::vector<int>{0, 3, 6, 9}));
  EXPECT_EQ(Chosen(Path(10, 0, 2), options), (std::vector<int>{0, 3, 6, 9}));
  EXPECT_EQ(Chosen(Path(4, 0.2, 0), options), (std::vector<int>{0, 1, 2, 3}));
}

TEST(FramesToFuse, ACameraThatStandsStillIsFusedEveryFewFrames) {
  EXPECT_EQ(Chosen(Path(10, 0, 0), {0.1, 5, 4}), (std::vector<int>{0, 4, 8}));
  EXPECT_EQ(Chosen(Path(3, 0, 0), {0.1, 5, 1}), (std::vector<int>{0, 1, 2}));
}

TEST(FramesToFuse, OfKeyframesHalfTheMotionIsAsked) {
  std::vector<TrackedFrame> path = Path(6, 0.03, 0);
  path[2].keyframe = path[2].frame;
  EXPECT_EQ(Chosen(path, {0.1, 5, 1000}), (std::vector<int>{0, 2}));
  path[2].keyframe = FrameIdx{0};
  EXPECT_EQ(Chosen(path, {0.1, 5, 1000}), (std::vector<int>{0, 4}));
}

TEST(FramesToFuse, LeavesOutFramesWithoutAPose) {
  std::vector<TrackedFrame> path = Path(4, 0.2, 0);
  path[0].status = TrackingStatus::kLost;
  path[2].status = TrackingStatus::kDegenerate;
  EXPECT_EQ(Chosen(path, {0.1, 5, 1000}), (std::vector<int>{1, 2, 3}));
  EXPECT_TRUE(Chosen({}, {}).empty());
}

}  // namespace
}  // namespace deepslam::fuse
