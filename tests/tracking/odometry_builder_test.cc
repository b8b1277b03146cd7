#include "deepslam/tracking/odometry_builder.h"

#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/pose_matchers.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;
using testing_support::PoseNear;

constexpr double kInterval_s = 0.1;

Pose3 AlongX(double x_m) { return {Eigen::Quaterniond::Identity(), {x_m, 0, 0}}; }

PosedFrame At(int frame, double x_m) {
  PosedFrame posed;
  posed.frame = FrameIdx{frame};
  posed.time_s = kInterval_s * frame;
  posed.pyramid = std::make_shared<const FramePyramid>();
  posed.world_from_camera = AlongX(x_m);
  return posed;
}

std::vector<double> Times(int num_frames) {
  std::vector<double> times_s;
  for (int k = 0; k < num_frames; ++k) times_s.push_back(kInterval_s * k);
  return times_s;
}

// Frame 0, a keyframe; 1 aligned to it; 2 and 3 lost; 4 aligned and a keyframe.
OdometryBuilder WithALoss() {
  OdometryBuilder builder{OdometryOptions{}};
  builder.AddFirst(At(0, 0));
  builder.AddKeyframe(FrameIdx{0});
  builder.AddAligned(At(1, 1), FrameIdx{0}, FrameAlignment{});
  builder.AddUnaligned(At(2, 1), FrameIdx{0}, TrackingStatus::kUnreadable);
  builder.AddUnaligned(At(3, 1), FrameIdx{0}, TrackingStatus::kLost);
  builder.AddUncertainEdge(At(0, 0), At(4, 4));
  builder.AddKeyframe(FrameIdx{4});
  builder.AddAligned(At(4, 4), FrameIdx{4}, FrameAlignment{});
  return builder;
}

TEST(OdometryBuilder, LaysLostFramesBetweenTheirNeighbours) {
  const Odometry odometry = WithALoss().Finish(Times(5));
  ASSERT_EQ(odometry.frames.size(), 5U);
  EXPECT_THAT(odometry.frames[2].world_from_camera, PoseNear(AlongX(2), 1e-9, 1e-6));
  EXPECT_THAT(odometry.frames[3].world_from_camera, PoseNear(AlongX(3), 1e-9, 1e-6));
  EXPECT_EQ(odometry.frames[3].status, TrackingStatus::kLost);
  EXPECT_EQ(odometry.keyframes, (std::vector<FrameIdx>{FrameIdx{0}, FrameIdx{4}}));
}

TEST(OdometryBuilder, SaysWhichEdgesAreGuessed) {
  const Odometry odometry = WithALoss().Finish(Times(5));
  ASSERT_EQ(odometry.edges.size(), 1U);
  EXPECT_TRUE(odometry.edges[0].composed);
  EXPECT_THAT(odometry.edges[0].i_from_j, PoseNear(AlongX(4), 1e-9, 1e-6));
  const OdometryOptions options;
  EXPECT_NEAR(odometry.edges[0].information.Full()(0, 0),
              1 / (options.lost_translation_m * options.lost_translation_m),
              1e-9);
}

TEST(OdometryBuilder, GivesUpFramesWithTheirKeyframesAndEdges) {
  OdometryBuilder builder = WithALoss();
  builder.AddEdge(At(4, 4), At(5, 5), FrameAlignment{});
  builder.AddKeyframe(FrameIdx{5});
  builder.AddAligned(At(5, 5), FrameIdx{5}, FrameAlignment{});
  builder.GiveUp(FrameIdx{2}, FrameIdx{5}, FrameIdx{0});
  const Odometry odometry = std::move(builder).Finish(Times(6));
  EXPECT_EQ(odometry.keyframes, std::vector<FrameIdx>{FrameIdx{0}});
  EXPECT_TRUE(odometry.edges.empty());
  EXPECT_EQ(odometry.frames[1].status, TrackingStatus::kTracked);
  EXPECT_EQ(odometry.frames[2].status, TrackingStatus::kUnreadable) << "that, it stays";
  EXPECT_EQ(odometry.frames[4].status, TrackingStatus::kLost);
  EXPECT_EQ(odometry.frames[4].keyframe, FrameIdx{0});
  EXPECT_EQ(odometry.frames[5].status, TrackingStatus::kTracked);
}

TEST(OdometryBuilder, MovesFramesInTheWorld) {
  OdometryBuilder builder = WithALoss();
  builder.Move(4, AlongX(10));
  EXPECT_THAT(std::move(builder).Finish(Times(5)).frames[4].world_from_camera,
              PoseNear(AlongX(14), 1e-9, 1e-6));
}

TEST(OdometryBuilder, AfterAllWasGivenUpBeginsAnew) {
  OdometryBuilder builder = WithALoss();
  builder.GiveUpAll();
  EXPECT_TRUE(builder.keyframes().empty());
  builder.AddFirst(At(5, 0));
  builder.AddKeyframe(FrameIdx{5});
  const Odometry odometry = std::move(builder).Finish(Times(6));
  for (const std::size_t k : {0U, 1U, 3U, 4U}) {
    EXPECT_EQ(odometry.frames[k].status, TrackingStatus::kLost) << k;
    EXPECT_EQ(odometry.frames[k].keyframe, FrameIdx{5}) << k;
  }
  EXPECT_EQ(odometry.frames[2].status, TrackingStatus::kUnreadable);
  EXPECT_TRUE(odometry.edges.empty());
}

}  // namespace
}  // namespace deepslam::tracking
