#include "deepslam/tracking/sub_trajectories.h"

#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::tracking {
namespace {

std::vector<int> All(const SubTrajectories& sub_trajectories, int num_frames) {
  std::vector<int> all;
  for (int k = 0; k < num_frames; ++k) all.push_back(sub_trajectories.Of(FrameIdx{k}));
  return all;
}

// Frames 0 1 2 of the first; a loss at 3, where another begins; back in the first at 5, and in the
// other at 6.
SubTrajectories ThereAndBack() {
  SubTrajectories sub_trajectories;
  for (int k = 0; k < 4; ++k) sub_trajectories.Add(0);
  const int other = sub_trajectories.Begin(FrameIdx{3});
  sub_trajectories.Add(other);
  sub_trajectories.Add(0);
  sub_trajectories.Add(other);
  return sub_trajectories;
}

TEST(SubTrajectories, BeginAtTheFrameThatWasLost) {
  const SubTrajectories sub_trajectories = ThereAndBack();
  EXPECT_EQ(sub_trajectories.newest(), 1);
  EXPECT_EQ(sub_trajectories.StartOf(0), FrameIdx{0});
  EXPECT_EQ(sub_trajectories.StartOf(1), FrameIdx{3});
  EXPECT_EQ(All(sub_trajectories, 7), (std::vector<int>{0, 0, 0, 1, 1, 0, 1}));
}

TEST(SubTrajectories, JoinWithAllTheirFramesAndNoOthers) {
  SubTrajectories sub_trajectories = ThereAndBack();
  EXPECT_EQ(sub_trajectories.Join(1, 0), (std::vector<std::size_t>{3, 4, 6}));
  EXPECT_EQ(All(sub_trajectories, 7), std::vector<int>(7, 0));
  EXPECT_TRUE(sub_trajectories.Join(1, 0).empty()) << "nothing is left of it";
  // Numbers are not used again.
  sub_trajectories.Add(0);
  EXPECT_EQ(sub_trajectories.Begin(FrameIdx{7}), 2);
}

TEST(SubTrajectories, BeginAnewAfterAReset) {
  SubTrajectories sub_trajectories = ThereAndBack();
  sub_trajectories.Reset();
  EXPECT_EQ(sub_trajectories.newest(), 0);
  EXPECT_EQ(All(sub_trajectories, 7), std::vector<int>(7, 0));
}

}  // namespace
}  // namespace deepslam::tracking
