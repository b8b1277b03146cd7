#include "deepslam/overrides/apply_to_ground.h"

#include <gmock/gmock.h>

#include "overrides/sample_objects.h"

namespace deepslam::overrides {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(ApplyToGround, LeavesSubTrajectoriesAloneThatWereNotRegisteredToTheFirstCamera) {
  const Overrides hint = Parsed("ground: {up_camera: [0, -1, 0], height_m: 1.4}\n");
  Odometry odometry;
  odometry.frames.resize(2);
  const Plane low{-Eigen::Vector3d::UnitY(), 0.7};
  Ground ground;
  ground.plane_world = low;
  ground.observations = {{FrameIdx{0}, low, Eigen::Matrix3d::Identity(), 1},
                         {FrameIdx{1}, low, Eigen::Matrix3d::Identity(), 1}};
  ground.apart = {{FrameIdx{1}, FrameIdx{2}, low}};
  EXPECT_THAT(ApplyToGround(hint, odometry, ground), ElementsAre(HasSubstr("1 of 2")));
  EXPECT_DOUBLE_EQ(ground.plane_world->d_m, 1.4);
  ASSERT_EQ(ground.observations.size(), 1U);
  EXPECT_EQ(ground.observations[0].keyframe, FrameIdx{1});
  EXPECT_DOUBLE_EQ(ground.apart[0].plane_world->d_m, 0.7);
}

TEST(ApplyToGround, HintStandsInForGroundThatDisagrees) {
  Odometry odometry;
  odometry.frames.resize(2);
  odometry.frames[1].world_from_camera.translation_m = {0, -0.2, 0};  // 0.2 m higher
  const Plane floor{{0, -1, 0}, 1.4};
  const Plane table{{0, -1, 0}, 0.7};
  Ground found;
  found.plane_world = table;
  found.observations = {{FrameIdx{0}, table}, {FrameIdx{1}, {{0, -1, 0}, 1.6}}};
  const Overrides hint = Parsed("ground: {up_camera: [0, -2, 0], height_m: 1.38}");
  EXPECT_EQ(ApplyToGround(hint, odometry, found).size(), 1U);
  ASSERT_EQ(found.observations.size(), 1U);
  EXPECT_EQ(found.observations[0].keyframe.value, 1);
  EXPECT_NEAR(found.plane_world->d_m, 1.38, 1e-12);
  // One that agrees stays as it was measured.
  Ground good;
  good.plane_world = floor;
  EXPECT_EQ(ApplyToGround(hint, odometry, good).size(), 1U);
  EXPECT_EQ(*good.plane_world, floor);
}

}  // namespace
}  // namespace deepslam::overrides
