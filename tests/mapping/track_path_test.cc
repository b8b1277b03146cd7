#include "deepslam/mapping/track_path.h"

#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "mapping/walked_room.h"
#include "support/pose_matchers.h"

namespace deepslam::mapping {
namespace {

using ::deepslam::testing_support::PoseNear;

// To the side and back, so that the same is seen twice.
std::vector<Pose3> ToAndFro() {
  std::vector<Pose3> poses;
  for (int k = 0; k < 30; ++k) {
    const int step = k < 15 ? k : 29 - k;
    poses.push_back(Looking({-1 + 0.03 * step, 0.2, 1.4}, 0.03 * step));
  }
  return poses;
}

TEST(TrackPath, IsTheTrackedPathRefined) {
  const std::vector<Pose3> truth = ToAndFro();
  const dataset::MemoryFrameSource frames = SourceOf(FramesAlong({}, truth));
  RecordingProgress progress;
  const Result<TrackedPath> path = TrackPath(frames, {}, {}, InMemory(), progress);
  ASSERT_TRUE(path.ok());
  EXPECT_LT(LargestError_m(path->odometry.frames, truth), 0.02);
  ASSERT_NE(path->odometry.more_edges, nullptr);
  EXPECT_GT(path->odometry.more_edges->size(), 0u);
  const Result<Odometry> tracked = tracking::EstimateOdometry(frames, {}, progress);
  ASSERT_TRUE(tracked.ok());
  ASSERT_EQ(path->world_from_camera_as_tracked.size(), tracked->frames.size());
  for (std::size_t k = 0; k < tracked->frames.size(); ++k) {
    EXPECT_EQ(path->world_from_camera_as_tracked[k], tracked->frames[k].world_from_camera);
    EXPECT_EQ(path->odometry.frames[k].status, tracked->frames[k].status);
  }
  EXPECT_EQ(path->odometry.edges.size(), tracked->edges.size());
}

TEST(TrackPath, OfFramesThatCannotBeReadIsAnError) {
  std::vector<Frame> frames = FramesAlong({}, ToAndFro());
  for (Frame& frame : frames) MakeUnreadable(frame);
  const dataset::MemoryFrameSource source = SourceOf(std::move(frames));
  RecordingProgress progress;
  const Result<TrackedPath> path = TrackPath(source, {}, {}, InMemory(), progress);
  ASSERT_FALSE(path.ok());
  EXPECT_EQ(path.error().code, ErrorCode::kInvalidInput);
}

TEST(TrackPath, EndsWhenAskedTo) {
  const dataset::MemoryFrameSource frames = SourceOf(FramesAlong({}, ToAndFro()));
  RecordingProgress progress(3);
  const Result<TrackedPath> path = TrackPath(frames, {}, {}, InMemory(), progress);
  ASSERT_FALSE(path.ok());
  EXPECT_EQ(path.error().code, ErrorCode::kInterrupted);
}

TEST(TakePathOfCapture, IsThePathThatCameWithIt) {
  const std::vector<Pose3> truth = ToAndFro();
  const dataset::MemoryFrameSource frames(
      kCamera, FramesAlong({}, truth), {truth.begin(), truth.end()});
  RecordingProgress progress;
  const Result<TrackedPath> path = TakePathOfCapture(frames, {}, progress);
  ASSERT_TRUE(path.ok());
  EXPECT_LT(LargestError_m(path->odometry.frames, truth), 1e-9);
  EXPECT_EQ(path->odometry.more_edges, nullptr);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_EQ(path->world_from_camera_as_tracked[k], path->odometry.frames[k].world_from_camera);
  }
  const dataset::MemoryFrameSource without = SourceOf(FramesAlong({}, truth));
  EXPECT_FALSE(TakePathOfCapture(without, {}, progress).ok());
}

}  // namespace
}  // namespace deepslam::mapping
