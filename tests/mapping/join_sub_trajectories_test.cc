#include "deepslam/mapping/join_sub_trajectories.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "mapping/walked_room.h"
#include "support/pose_matchers.h"

namespace deepslam::mapping {
namespace {

using ::deepslam::testing_support::PoseNear;
using loop::testing_support::Round;
using testing::IsEmpty;

constexpr int kPerLap = 40;
constexpr int kNumKeyframes = 52;  // the last twelve stand where the first twelve stood
constexpr std::size_t kLost = 20;

// Tracking is lost before keyframe kLost: it goes on from where it last was, turned by 60 deg.
Odometry LostOnce(const std::vector<Pose3>& truth) {
  const Pose3 astray = V2t((Vector6d() << 0.4, -0.3, 0.1, 0, 0, 1).finished());
  std::vector<Pose3> poses = truth;
  for (std::size_t k = kLost; k < poses.size(); ++k) poses[k] = astray * poses[k];
  Odometry odometry = TrackedAs(poses);
  odometry.frames[kLost].status = TrackingStatus::kLost;
  RelativePose& edge = odometry.edges[kLost - 1];
  edge.composed = true;
  edge.information = Matrix6d::Identity();
  return odometry;
}

struct Walk {
  std::vector<Pose3> truth = Round(kNumKeyframes, (kNumKeyframes - 1.0) / kPerLap);
  std::vector<Frame> frames = FramesAlong({}, truth);
  Odometry tracked = LostOnce(truth);
};

Result<Odometry> Joined(Walk walk, Progress& progress) {
  const dataset::MemoryFrameSource source = SourceOf(std::move(walk.frames));
  return JoinSubTrajectories(source, std::move(walk.tracked), {}, progress);
}

void ExpectAsItWas(const Odometry& joined, const Odometry& tracked) {
  EXPECT_EQ(joined.edges.size(), tracked.edges.size());
  for (std::size_t k = 0; k < tracked.frames.size(); ++k)
    EXPECT_EQ(joined.frames[k].world_from_camera, tracked.frames[k].world_from_camera);
}

TEST(JoinSubTrajectories, ThoseThatShowOnePlaceBecomeOnePath) {
  const Walk walk;
  ASSERT_EQ(CountSubTrajectories(walk.tracked), 2);
  ASSERT_GT(LargestError_m(walk.tracked.frames, walk.truth), 0.4);
  RecordingProgress progress;
  const Result<Odometry> joined = Joined(walk, progress);
  ASSERT_TRUE(joined.ok());
  EXPECT_THAT(progress.warnings, IsEmpty());
  EXPECT_EQ(CountSubTrajectories(*joined), 1);
  EXPECT_LT(LargestError_m(joined->frames, walk.truth), 0.03);
  EXPECT_THAT(joined->frames.front().world_from_camera,
              PoseNear(walk.tracked.frames.front().world_from_camera, 1e-12, 1e-9));
}

TEST(JoinSubTrajectories, OnlyWhatLiesBetweenThemIsAnEdgeOfThePath) {
  const Walk walk;
  RecordingProgress progress;
  const Result<Odometry> joined = Joined(walk, progress);
  ASSERT_TRUE(joined.ok());
  ASSERT_GT(joined->edges.size(), walk.tracked.edges.size());
  for (std::size_t n = walk.tracked.edges.size(); n < joined->edges.size(); ++n) {
    const RelativePose& edge = joined->edges[n];
    const auto i = static_cast<std::size_t>(edge.i.value);
    const auto j = static_cast<std::size_t>(edge.j.value);
    EXPECT_NE(i < kLost, j < kLost);
    EXPECT_FALSE(edge.composed);
    EXPECT_THAT(edge.i_from_j, PoseNear(walk.truth[i].Inverse() * walk.truth[j], 0.01, 0.3));
  }
}

// Another room behind the loss: nothing is seen from both.
TEST(JoinSubTrajectories, TwoRoomsStayTwo) {
  Walk walk;
  TexturedRoom other;
  other.seed = 2;
  other.room = {{-4.2, -3.6, -0.4}, {4.2, 3.6, 3.4}};
  other.boxes.clear();
  for (std::size_t k = kLost; k < walk.frames.size(); ++k)
    walk.frames[k] = Photograph(other, walk.truth[k], static_cast<int>(k));
  RecordingProgress progress;
  const Result<Odometry> joined = Joined(walk, progress);
  ASSERT_TRUE(joined.ok());
  EXPECT_EQ(CountSubTrajectories(*joined), 2);
  ExpectAsItWas(*joined, walk.tracked);
}

// Loops are the business of a later stage, whatever drifted.
TEST(JoinSubTrajectories, OnePathIsNotLookedAt) {
  Walk walk;
  walk.tracked = TrackedAs(Drifting(walk.truth, 3));
  for (Frame& frame : walk.frames) MakeUnreadable(frame);
  RecordingProgress progress;
  const Result<Odometry> joined = Joined(walk, progress);
  ASSERT_TRUE(joined.ok());
  EXPECT_THAT(progress.warnings, IsEmpty());
  ExpectAsItWas(*joined, walk.tracked);
}

TEST(JoinSubTrajectories, FramesThatCannotBeReadJoinNothing) {
  Walk walk;
  for (std::size_t k = kLost; k < walk.frames.size(); ++k) MakeUnreadable(walk.frames[k]);
  RecordingProgress progress;
  const Result<Odometry> joined = Joined(walk, progress);
  ASSERT_TRUE(joined.ok());
  EXPECT_FALSE(progress.warnings.empty());
  ExpectAsItWas(*joined, walk.tracked);
}

TEST(JoinSubTrajectories, EndsWhenAskedTo) {
  RecordingProgress progress(1);
  const Result<Odometry> joined = Joined({}, progress);
  ASSERT_FALSE(joined.ok());
  EXPECT_EQ(joined.error().code, ErrorCode::kInterrupted);
}

TEST(JoinSubTrajectories, TheNumberOfThreadsChangesNothing) {
  const Walk walk;
  const auto join = [&](int threads) {
    const ThreadLimit limit(threads);
    RecordingProgress progress;
    return *Joined(walk, progress);
  };
  const Odometry one = join(1);
  const Odometry four = join(4);
  ASSERT_EQ(one.edges.size(), four.edges.size());
  for (std::size_t k = 0; k < one.frames.size(); ++k)
    EXPECT_EQ(one.frames[k].world_from_camera, four.frames[k].world_from_camera);
}

}  // namespace
}  // namespace deepslam::mapping
