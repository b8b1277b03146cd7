#include "deepslam/fuse/fuse_coarse.h"

#include <gtest/gtest.h>

#include "support/box_world.h"
#include "support/recording_progress.h"

namespace deepslam::fuse {
namespace {

using testing_support::BoxWorldSource;
using testing_support::RecordingProgress;

std::vector<Pose3> Places() {
  std::vector<Pose3> poses;
  for (const double y : {-0.8, -0.4, 0.0, 0.4, 0.8})
    poses.push_back(testing_support::LookAt({-1, y, 1.4}, {2, 0.2 * y, 1.0}));
  return poses;
}

BoxWorldSource WallAhead() { return {{{-1, {2, -2, 0}, {2.2, 2, 2.4}}}, Places()}; }

TEST(CoarseFrames, LeavesOutWhatWasNotRegisteredToTheFirstKeyframe) {
  const Odometry path = WallAhead().TrueOdometry();
  Ground ground;
  EXPECT_EQ(CoarseFrames(path.frames, ground, {0.1, 90, 100}).size(), 5U);
  ground.apart = {{FrameIdx{2}, FrameIdx{4}, std::nullopt}};
  EXPECT_EQ(CoarseFrames(path.frames, ground, {0.1, 90, 100}),
            (std::vector<FrameIdx>{{0}, {1}, {4}}));
  EXPECT_TRUE(CoarseFrames({}, ground, {}).empty());
}

TEST(FuseCoarse, IsInTheLevelWorld) {
  const BoxWorldSource frames = WallAhead();
  const Odometry path = frames.TrueOdometry();
  const Pose3 level_from_tracking{Eigen::Quaterniond::Identity(), {10, 0, 0}};
  RecordingProgress progress;
  const Result<CoarseSurface> surface =
      FuseCoarse({frames, path.frames, level_from_tracking, true}, path.keyframes, {}, progress);
  ASSERT_TRUE(surface.ok());
  EXPECT_TRUE(surface->has_ground);
  EXPECT_EQ(surface->level_from_tracking.translation_m, level_from_tracking.translation_m);
  EXPECT_EQ(surface->viewpoints.size(), 5U);
  EXPECT_TRUE(progress.warnings.empty());
  int num_on_wall = 0;
  for (const Eigen::Vector3f& p : surface->mesh.vertices)
    num_on_wall += std::abs(p.x() - 12.0F) < 0.03F && p.z() > 0.2F ? 1 : 0;
  EXPECT_GT(num_on_wall, 500);
}

TEST(FuseCoarse, WarnsOfFramesThatCannotBeReadAndGoesOn) {
  BoxWorldSource frames = WallAhead();
  frames.broken = {1, 3};
  const Odometry path = frames.TrueOdometry();
  RecordingProgress progress;
  const Result<CoarseSurface> surface =
      FuseCoarse({frames, path.frames, {}, false}, path.keyframes, {}, progress);
  ASSERT_TRUE(surface.ok());
  EXPECT_EQ(surface->viewpoints.size(), 3U);
  EXPECT_EQ(progress.warnings.size(), 2U);
  EXPECT_FALSE(surface->has_ground);
}

TEST(FuseCoarse, SaysWhereTheSurfaceOutgrewItsBound) {
  const BoxWorldSource frames = WallAhead();
  const Odometry path = frames.TrueOdometry();
  CoarseOptions options;
  options.max_voxel_blocks = 2;
  RecordingProgress progress;
  const Result<CoarseSurface> surface =
      FuseCoarse({frames, path.frames, {}, true}, path.keyframes, options, progress);
  ASSERT_TRUE(surface.ok());
  ASSERT_EQ(progress.warnings.size(), 1U);
  EXPECT_NE(progress.warnings[0].find("max_voxel_blocks"), std::string::npos);
}

TEST(FuseCoarse, StopsWhenAsked) {
  const BoxWorldSource frames = WallAhead();
  const Odometry path = frames.TrueOdometry();
  RecordingProgress progress(1);
  const Result<CoarseSurface> surface =
      FuseCoarse({frames, path.frames, {}, true}, path.keyframes, {}, progress);
  ASSERT_FALSE(surface.ok());
  EXPECT_EQ(surface.error().code, ErrorCode::kInterrupted);
}

TEST(FuseCoarse, OfNoFramesIsEmpty) {
  const BoxWorldSource frames = WallAhead();
  RecordingProgress progress;
  const Result<CoarseSurface> surface = FuseCoarse({frames, {}, {}, true}, {}, {}, progress);
  ASSERT_TRUE(surface.ok());
  EXPECT_TRUE(surface->mesh.empty());
}

}  // namespace
}  // namespace deepslam::fuse
