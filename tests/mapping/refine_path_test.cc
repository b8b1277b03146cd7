#include "deepslam/mapping/refine_path.h"

#include <cmath>
#include <numbers>
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
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kNumKeyframes = 24;

// A camera that sweeps to and fro, 50 deg in six keyframes, while it is carried along.
std::vector<Pose3> Sweeping() {
  std::vector<Pose3> poses;
  for (int k = 0; k < kNumKeyframes; ++k) {
    poses.push_back(
        Looking({-1 + 0.02 * k, 0.2, 1.4}, 0.43 * std::sin(2 * std::numbers::pi * k / 12)));
  }
  return poses;
}

struct Walk {
  std::vector<Pose3> truth = Sweeping();
  std::vector<Frame> frames = FramesAlong({}, truth);
  Odometry tracked = TrackedAs(Drifting(truth, 2));
};

Result<Odometry> Refined(Walk walk,
                         Progress& progress,
                         const RefinementOptions& options = {},
                         const EdgeStoreFactory& new_store = InMemory()) {
  const dataset::MemoryFrameSource source = SourceOf(std::move(walk.frames));
  return RefinePath(
      std::move(walk.tracked), PyramidsToRefine(source, options), options, new_store, progress);
}

TEST(RefinePath, KeyframesThatSeeTheSameTakeDriftOutOfThePath) {
  const Walk walk;
  RecordingProgress progress;
  const Result<Odometry> refined = Refined(walk, progress);
  ASSERT_TRUE(refined.ok());
  EXPECT_THAT(progress.warnings, IsEmpty());
  const double drift_m = LargestError_m(walk.tracked.frames, walk.truth);
  ASSERT_GT(drift_m, 0.02);
  EXPECT_LT(LargestError_m(refined->frames, walk.truth), drift_m / 3);
}

TEST(RefinePath, WhatWasMeasuredLiesInTheStoreInOrderAndIsTrue) {
  const Walk walk;
  RecordingProgress progress;
  const Result<Odometry> refined = Refined(walk, progress);
  ASSERT_TRUE(refined.ok());
  EXPECT_EQ(refined->edges.size(), walk.tracked.edges.size());
  ASSERT_NE(refined->more_edges, nullptr);
  EXPECT_GT(refined->more_edges->size(), static_cast<std::size_t>(kNumKeyframes));
  int newest = 0;
  ForEach(*refined->more_edges, [&](const RelativePose& edge) {
    EXPECT_LE(newest, edge.j.value);
    newest = edge.j.value;
    EXPECT_THAT(edge.i_from_j,
                PoseNear(walk.truth[static_cast<std::size_t>(edge.i.value)].Inverse() *
                             walk.truth[static_cast<std::size_t>(edge.j.value)],
                         0.02,
                         0.5));
  });
}

TEST(RefinePath, TheNumberOfThreadsChangesNothing) {
  const Walk walk;
  const auto refine = [&](int threads) {
    const ThreadLimit limit(threads);
    RecordingProgress progress;
    return *Refined(walk, progress);
  };
  const Odometry one = refine(1);
  const Odometry four = refine(4);
  ASSERT_EQ(one.num_edges(), four.num_edges());
  for (std::size_t k = 0; k < one.frames.size(); ++k)
    EXPECT_EQ(one.frames[k].world_from_camera, four.frames[k].world_from_camera);
}

TEST(RefinePath, AKeyframeThatCannotBeReadIsToldAndTheOthersGoOn) {
  Walk walk;
  MakeUnreadable(walk.frames[7]);
  RecordingProgress progress;
  const Result<Odometry> refined = Refined(walk, progress);
  ASSERT_TRUE(refined.ok());
  EXPECT_THAT(progress.warnings, Contains(HasSubstr("frame 7")));
  ASSERT_NE(refined->more_edges, nullptr);
  ForEach(*refined->more_edges, [](const RelativePose& edge) {
    EXPECT_NE(edge.i, FrameIdx{7});
    EXPECT_NE(edge.j, FrameIdx{7});
  });
  EXPECT_LT(LargestError_m(refined->frames, walk.truth),
            LargestError_m(walk.tracked.frames, walk.truth) / 2);
}

// Tracking's own edges alone say nothing new.
TEST(RefinePath, WhatSeesNothingAgainStaysAsTracked) {
  Walk walk;
  for (Frame& frame : walk.frames) MakeUnreadable(frame);
  RecordingProgress progress;
  const Result<Odometry> refined = Refined(walk, progress);
  ASSERT_TRUE(refined.ok());
  EXPECT_EQ(refined->more_edges, nullptr);
  for (std::size_t k = 0; k < refined->frames.size(); ++k) {
    EXPECT_EQ(refined->frames[k].world_from_camera, walk.tracked.frames[k].world_from_camera);
  }
}

TEST(RefinePath, SwitchedOffStaysAsTracked) {
  const Walk walk;
  RefinementOptions off;
  off.covisible.enabled = false;
  RecordingProgress progress;
  const Result<Odometry> refined = Refined(walk, progress, off);
  ASSERT_TRUE(refined.ok());
  EXPECT_EQ(refined->more_edges, nullptr);
  EXPECT_EQ(refined->frames.back().world_from_camera, walk.tracked.frames.back().world_from_camera);
}

TEST(RefinePath, EndsWhenAskedTo) {
  const Walk walk;
  RecordingProgress progress(2);
  const Result<Odometry> refined = Refined(walk, progress);
  ASSERT_FALSE(refined.ok());
  EXPECT_EQ(refined.error().code, ErrorCode::kInterrupted);
}

class FullStore final : public EdgeStore {
 public:
  [[nodiscard]] Status Add(const RelativePose&) override { return Failed("no space left"); }
  [[nodiscard]] std::size_t size() const override { return 0; }
  void Read(std::size_t, std::span<RelativePose>) const override {}
};

TEST(RefinePath, AStoreWithoutRoomIsAnError) {
  const Walk walk;
  RecordingProgress progress;
  const Result<Odometry> refined =
      Refined(walk, progress, {}, [] { return std::make_shared<FullStore>(); });
  ASSERT_FALSE(refined.ok());
  EXPECT_EQ(refined.error().message, "no space left");
}

}  // namespace
}  // namespace deepslam::mapping
