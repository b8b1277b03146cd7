#include "deepslam/mapping/close_by_appearance.h"

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
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kPerLap = 40;
constexpr int kNumKeyframes = 52;  // the last twelve stand where the first twelve stood

// Tracking that is off more and more: by 0.4 m and 6 deg at the last keyframe.
std::vector<Pose3> Drifted(const std::vector<Pose3>& truth) {
  const Vector6d end = (Vector6d() << 0.35, -0.2, 0.05, 0, 0, 0.1).finished();
  std::vector<Pose3> poses;
  for (std::size_t k = 0; k < truth.size(); ++k)
    poses.push_back(V2t(static_cast<double>(k) / (kNumKeyframes - 1.0) * end) * truth[k]);
  return poses;
}

struct Walk {
  std::vector<Pose3> truth = Round(kNumKeyframes, (kNumKeyframes - 1.0) / kPerLap);
  std::vector<Frame> frames = FramesAlong({}, truth);
  Odometry tracked = TrackedAs(Drifted(truth));
};

Result<ClosedTrajectory> Closed(Walk walk,
                                Progress& progress,
                                const AppearanceClosing& options = {}) {
  const dataset::MemoryFrameSource source = SourceOf(std::move(walk.frames));
  return CloseByAppearance(source, walk.tracked, {}, options, progress);
}

void ExpectAsTracked(const ClosedTrajectory& closed, const Odometry& tracked) {
  EXPECT_THAT(closed.appearance.edges, IsEmpty());
  for (std::size_t k = 0; k < tracked.frames.size(); ++k)
    EXPECT_EQ(closed.frames[k].world_from_camera, tracked.frames[k].world_from_camera);
}

TEST(CloseByAppearance, APlaceSeenAgainTakesTheDriftOutOfThePath) {
  const Walk walk;
  RecordingProgress progress;
  const Result<ClosedTrajectory> closed = Closed(walk, progress);
  ASSERT_TRUE(closed.ok());
  EXPECT_THAT(progress.warnings, IsEmpty());
  EXPECT_GE(closed->appearance.edges.size(), 3u);
  EXPECT_EQ(closed->num_reregistered, 0);
  for (const RelativePose& edge : closed->appearance.edges) {
    EXPECT_THAT(edge.i_from_j,
                PoseNear(walk.truth[static_cast<std::size_t>(edge.i.value)].Inverse() *
                             walk.truth[static_cast<std::size_t>(edge.j.value)],
                         0.01,
                         0.3));
  }
  EXPECT_THAT(closed->frames.front().world_from_camera,
              PoseNear(walk.tracked.frames.front().world_from_camera, 1e-12, 1e-9));
  // At the end, where the drift was, and the loop measured it.
  EXPECT_THAT(
      closed->frames.front().world_from_camera.Inverse() * closed->frames.back().world_from_camera,
      PoseNear(walk.truth.front().Inverse() * walk.truth.back(), 0.03, 0.5));
}

// A poster that hangs in another room as well: corners find it, what is round it does not bear it
// out.
TEST(CloseByAppearance, APosterSeenInAnotherRoomIsNoLoop) {
  Walk walk;
  TexturedRoom other;
  other.seed = 2;
  other.room = {{-4.2, -3.6, -0.4}, {4.2, 3.6, 3.4}};
  other.boxes.clear();
  for (int k = kPerLap / 2; k < kNumKeyframes; ++k) {
    Frame& frame = walk.frames[static_cast<std::size_t>(k)];
    const Frame round_it = Photograph(other, walk.truth[static_cast<std::size_t>(k)], k);
    for (int v = 0; v < kCamera.height; ++v) {
      for (int u = 0; u < kCamera.width; ++u) {
        if (60 <= u && u < 260 && 45 <= v && v < 195) continue;
        frame.colour(u, v) = round_it.colour(u, v);
        frame.depth_m(u, v) = round_it.depth_m(u, v);
      }
    }
  }
  RecordingProgress progress;
  const Result<ClosedTrajectory> closed = Closed(walk, progress);
  ASSERT_TRUE(closed.ok());
  ASSERT_FALSE(closed->appearance.loops.empty()) << "it is proposed";
  for (const AppearanceLoop& loop : closed->appearance.loops) {
    EXPECT_FALSE(loop.accepted);
    EXPECT_FALSE(loop.reason.empty());
  }
  ExpectAsTracked(*closed, walk.tracked);
}

TEST(CloseByAppearance, AWalkThatDoesNotComeBackStaysAsTracked) {
  Walk walk;
  walk.truth.resize(kPerLap * 3 / 4);
  walk.frames.resize(walk.truth.size());
  walk.tracked = TrackedAs(Drifted(walk.truth));
  RecordingProgress progress;
  const Result<ClosedTrajectory> closed = Closed(walk, progress);
  ASSERT_TRUE(closed.ok());
  EXPECT_THAT(closed->appearance.loops, IsEmpty());
  ExpectAsTracked(*closed, walk.tracked);
}

// Depth alone slid by half a metre between two keyframes; corners and intensity see it.
TEST(CloseByAppearance, AdjacentKeyframesMeasuredByDepthAloneAreRegisteredAgain) {
  Walk walk;
  walk.truth.clear();
  for (int k = 0; k < 12; ++k) walk.truth.push_back(Looking({-1 + 0.1 * k, 0.2, 1.4}, 0.3));
  walk.frames = FramesAlong({}, walk.truth);
  std::vector<Pose3> slid = walk.truth;
  for (std::size_t k = 6; k < slid.size(); ++k) slid[k].translation_m.x() += 0.5;
  walk.tracked = TrackedAs(slid);
  for (RelativePose& edge : walk.tracked.edges) edge.information = Matrix6d::Identity();
  RecordingProgress progress;
  AppearanceClosing options;
  const Result<ClosedTrajectory> by_images = Closed(walk, progress, options);
  ASSERT_TRUE(by_images.ok());
  EXPECT_EQ(by_images->num_reregistered, 0);
  ExpectAsTracked(*by_images, walk.tracked);
  options.by_depth_alone = true;
  options.alignment.photometric = false;
  const Result<ClosedTrajectory> by_depth = Closed(walk, progress, options);
  ASSERT_TRUE(by_depth.ok());
  EXPECT_EQ(by_depth->num_reregistered, 11);
  EXPECT_LT(LargestError_m(by_depth->frames, walk.truth), 0.02);
}

TEST(CloseByAppearance, AKeyframeThatCannotBeReadIsToldAndTheOthersGoOn) {
  Walk walk;
  MakeUnreadable(walk.frames[44]);
  RecordingProgress progress;
  const Result<ClosedTrajectory> closed = Closed(walk, progress);
  ASSERT_TRUE(closed.ok());
  EXPECT_THAT(progress.warnings, ElementsAre(HasSubstr("frame 44 is not looked at")));
  EXPECT_GE(closed->appearance.edges.size(), 3u);
  EXPECT_TRUE(std::ranges::none_of(closed->appearance.edges, [](const RelativePose& edge) {
    return edge.i == FrameIdx{44} || edge.j == FrameIdx{44};
  }));
}

TEST(CloseByAppearance, EndsWhenAskedTo) {
  const Walk walk;
  for (const int stop_after : {1, 3}) {  // while it looks at keyframes, and while it registers them
    RecordingProgress progress(stop_after);
    const Result<ClosedTrajectory> closed = Closed(walk, progress);
    ASSERT_FALSE(closed.ok());
    EXPECT_EQ(closed.error().code, ErrorCode::kInterrupted);
  }
}

TEST(CloseByAppearance, SwitchedOffStaysAsTracked) {
  const Walk walk;
  AppearanceClosing off;
  off.appearance.enabled = false;
  RecordingProgress progress;
  const Result<ClosedTrajectory> closed = Closed(walk, progress, off);
  ASSERT_TRUE(closed.ok());
  EXPECT_THAT(closed->appearance.loops, IsEmpty());
  ExpectAsTracked(*closed, walk.tracked);
}

TEST(CloseByAppearance, TheNumberOfThreadsChangesNothing) {
  const Walk walk;
  const auto close = [&](int threads) {
    const ThreadLimit limit(threads);
    RecordingProgress progress;
    return *Closed(walk, progress);
  };
  const ClosedTrajectory one = close(1);
  const ClosedTrajectory four = close(4);
  ASSERT_EQ(one.appearance.edges.size(), four.appearance.edges.size());
  for (std::size_t k = 0; k < one.frames.size(); ++k)
    EXPECT_EQ(one.frames[k].world_from_camera, four.frames[k].world_from_camera);
}

}  // namespace
}  // namespace deepslam::mapping
