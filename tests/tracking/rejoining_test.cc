#include "deepslam/tracking/rejoining.h"

#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "support/pose_matchers.h"
#include "tracking/small_path.h"

namespace deepslam::tracking {
namespace {

using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::PoseNear;

// Where the second sub-trajectory is taken to be, for want of anything better.
const Pose3 kGuessed = V2t((Vector6d() << 0.5, -0.3, 0.2, 0, 0, 0.4).finished());

constexpr int kBegins = 150;  // its first frame
constexpr int kNumFrames = 500;

// Two keyframes of a path, a loss, and another sub-trajectory that comes back to the first
// keyframe. `world` is what the second sees before it comes back, and its images are of where it
// truly is.
class FindRejoiningTest : public ::testing::Test {
 protected:
  std::optional<Rejoining> Rejoined(const BoxWorld& world,
                                    const std::vector<Pose3>& second,
                                    int frames_between) {
    SmallPath path;
    path.Add(Posed(BoxWorld::Furnished(), truth_[0], 0));
    path.Add(Posed(BoxWorld::Furnished(), truth_[1], 10));
    SubTrajectories sub_trajectories;
    MonotonicClock clock;
    for (int k = 0; k < kNumFrames; ++k) {
      sub_trajectories.Add(k < kBegins ? 0 : 1);
      clock.Advance(kFrameInterval_s * k);
    }
    sub_trajectories.Begin(FrameIdx{kBegins});
    int frame = kBegins;
    for (std::size_t k = 0; k + 1 < second.size(); ++k, frame += frames_between)
      path.Add(Guessed(world, second[k], frame));
    const PosedFrame back = Guessed(BoxWorld::Furnished(), second.back(), frame);
    return FindRejoining(path.SoFar(), back, sub_trajectories, clock);
  }

  static PosedFrame Guessed(const BoxWorld& world, const Pose3& truth, int frame) {
    PosedFrame posed = Posed(world, truth, frame, 1);
    posed.world_from_camera = kGuessed * truth;
    return posed;
  }

  const std::vector<Pose3> truth_ = Arc(2, 5.0);
};

TEST_F(FindRejoiningTest, BringsTheSubTrajectoryBackToWhereItBelongs) {
  const std::vector<Pose3> round = Arc(8, 12.0);
  const std::vector<Pose3> second = {round[3], round[2], round[0]};
  const auto found = Rejoined(BoxWorld::Furnished(), second, 4);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->keyframe.sub_trajectory, 0);
  EXPECT_FALSE(found->gives_up);
  EXPECT_THAT(found->motion * kGuessed, PoseNear(Pose3{}, 0.03, 0.8));
  EXPECT_THAT(found->keyframe.world_from_camera * found->alignment.i_from_j,
              PoseNear(second.back(), 0.02, 0.5));
}

TEST_F(FindRejoiningTest, LeavesASubTrajectoryThatSeesAnotherPlace) {
  const std::vector<Pose3> elsewhere = {testing_support::LookAt({0.5, 1.6, 1.2}, {-1.9, 1.7, 0.9}),
                                        testing_support::LookAt({0.5, 1.6, 1.2}, {-1.9, 1.9, 0.9})};
  EXPECT_FALSE(Rejoined(BoxWorld::Furnished(), elsewhere, 4).has_value());
}

// Something stood in the view, and the frames followed it: what they saw cannot be where the first
// keyframes saw through.
TEST_F(FindRejoiningTest, GivesUpAShortOneThatItsKeyframesContradict) {
  BoxWorld passed_by = BoxWorld::Furnished();
  passed_by.boxes.push_back({{-0.9, -0.75, 0}, {-0.5, -0.1, 1.7}});
  const std::vector<Pose3> second = {truth_[0], truth_[0], truth_[0]};
  const auto found = Rejoined(passed_by, second, 4);
  ASSERT_TRUE(found.has_value());
  EXPECT_TRUE(found->gives_up);
  EXPECT_THAT(found->motion * kGuessed, PoseNear(Pose3{}, 0.03, 0.8));
  // Nobody takes ten seconds to pass by: then the place is not this one.
  EXPECT_FALSE(Rejoined(passed_by, second, 100).has_value());
}

class IsPassingByTest : public ::testing::Test {
 protected:
  // The first sub-trajectory lasts until frame `begins`; the frame is `later` frames behind that.
  static bool Of(int begins, int later, KeyframeWindow keyframes = KeyframeWindow(2)) {
    SubTrajectories sub_trajectories;
    MonotonicClock clock;
    for (int k = 0; k <= begins + later; ++k) {
      sub_trajectories.Add(0);
      clock.Advance(kFrameInterval_s * k);
    }
    PosedFrame frame;
    frame.frame = FrameIdx{begins + later};
    frame.clock_s = clock.TimeOf(frame.frame);
    frame.sub_trajectory = sub_trajectories.Begin(FrameIdx{begins});
    return IsPassingBy(frame, 0, keyframes, sub_trajectories, clock);
  }

  static PosedFrame Keyframe(int frame, int sub_trajectory) {
    return Posed(BoxWorld::Furnished(), Pose3{}, frame, sub_trajectory);
  }
};

TEST_F(IsPassingByTest, IsShorterThanTwoSecondsAndThanWhatWasBefore) {
  EXPECT_TRUE(Of(100, 30));
  EXPECT_FALSE(Of(100, 50)) << "2.5 s";
  EXPECT_FALSE(Of(20, 30)) << "longer than what was before";
}

TEST_F(IsPassingByTest, IsNotToldWhereKeyframesOfOthersCameInBetween) {
  KeyframeWindow alone(4);
  alone.Push(Keyframe(90, 0));
  alone.Push(Keyframe(105, 1));
  EXPECT_TRUE(Of(100, 30, alone));
  alone.Push(Keyframe(110, 0));
  EXPECT_FALSE(Of(100, 30, alone));
}

}  // namespace
}  // namespace deepslam::tracking
