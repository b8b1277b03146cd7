#include "deepslam/alignment/reference_pixels.h"

#include <cstddef>

#include <gtest/gtest.h>

#include "alignment/box_world.h"

namespace deepslam::alignment {
namespace {

using testing_support::BoxWorld;
using testing_support::kSmallCamera;
using testing_support::RenderFrame;

FramePyramid Wall() {
  const Frame frame = RenderFrame(BoxWorld::Wall(), Pose3{}, 0.0);
  return AsReference(BuildPyramid(frame, kSmallCamera, PyramidOptions{}));
}

TEST(AsReference, NormalsOfAWallFaceTheCamera) {
  const FramePyramid pyramid = Wall();
  ASSERT_GE(pyramid.levels.size(), 2U);
  for (const PyramidLevel& level : pyramid.levels) {
    const std::size_t centre = static_cast<std::size_t>(
        level.camera.height / 2 * level.camera.width + level.camera.width / 2);
    EXPECT_NEAR(level.surface[centre].nz, -1.0F, 1e-3F);
    EXPECT_NEAR(level.surface[centre].offset_m, -2.0F, 1e-3F);
  }
}

void ExpectSignedByNormals(const PyramidLevel& level) {
  ASSERT_EQ(level.signed_depth_m.size(), level.depth_m.size());
  for (std::size_t k = 0; k < level.depth_m.size(); ++k) {
    const bool has_normal = level.surface[k].offset_m < 0;
    EXPECT_EQ(level.signed_depth_m[k], has_normal ? level.depth_m[k] : -level.depth_m[k]) << k;
  }
}

TEST(AsReference, DepthHasTheSignOfItsNormalAlsoWhereAPixelIsHidden) {
  FramePyramid pyramid = Wall();
  for (PyramidLevel& level : pyramid.levels) {
    ExpectSignedByNormals(level);
    const std::size_t centre = level.depth_m.size() / 2 + level.camera.width / 2;
    ASSERT_GT(level.depth_m[centre], 0);
    HidePixel(centre, level);
    EXPECT_EQ(level.depth_m[centre], 0);
    EXPECT_EQ(level.surface[centre].offset_m, 0);
    ExpectSignedByNormals(level);
  }
}

TEST(AsReference, IsToldFromAFrameThatWasNotPrepared) {
  const Frame frame = RenderFrame(BoxWorld::Wall(), Pose3{}, 0.0);
  EXPECT_FALSE(IsReference(BuildPyramid(frame, kSmallCamera, {})));
  EXPECT_FALSE(IsReference({}));
  EXPECT_TRUE(IsReference(Wall()));
}

}  // namespace
}  // namespace deepslam::alignment
