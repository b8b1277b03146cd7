#include "deepslam/loop/correction.h"

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam::loop {
namespace {

TEST(CorrectionFit, RecoversATurnAndAShift) {
  Random random(4);
  for (int n = 0; n < 20; ++n) {
    LevelCorrection truth;
    truth.yaw_rad = random.Uniform(-0.6, 0.6);
    truth.translation_m = {random.Normal(), random.Normal(), random.Normal()};
    CorrectionFit fit;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d p(3 * random.Normal(), 3 * random.Normal(), random.Normal());
      fit.AddPoint(truth * p, p);
      fit.AddYaw(truth.yaw_rad);
    }
    const LevelCorrection found = fit.Solve(0.01, 0.1);
    EXPECT_NEAR(found.yaw_rad, truth.yaw_rad, 1e-3);
  }
}

TEST(CorrectionFit, ASinglePointWithoutYawOnlyShifts) {
  CorrectionFit fit;
  fit.AddPoint({1, 2, 3}, {0, 0, 1});
  const LevelCorrection found = fit.Solve(0.1, 0.1);
  EXPECT_EQ(found.yaw_rad, 0.0);
  EXPECT_LT((found.translation_m - Eigen::Vector3d(1, 2, 2)).norm(), 1e-12);
  EXPECT_EQ(CorrectionFit().Solve(0.1, 0.1).yaw_rad, 0.0);
}

TEST(LevelCorrection, InAWorldThatIsNotLevelTurnsAboutItsUp) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.2, -1, 0.3).normalized();
  const Eigen::Quaterniond level_from_world = LevelFromWorld(up);
  LevelCorrection correction;
  correction.yaw_rad = 0.7;
  correction.translation_m = {0.1, 0.2, 0.3};
  const Pose3 in_world = correction.InWorld(level_from_world);
  EXPECT_LT((in_world.rotation * up - up).norm(), 1e-12);
  const Eigen::Vector3d p(1, -2, 3);
  EXPECT_LT((level_from_world * (in_world * p) - correction * (level_from_world * p)).norm(),
            1e-12);
}

TEST(UpDirection, IsNotSwayedByOneFallenObject) {
  ObjectMap map;
  EXPECT_EQ(UpDirection(map), Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d up = Eigen::Vector3d(0, -1, 0.1).normalized();
  map.objects.resize(5);
  for (MapObject& object : map.objects) {
    object.world_from_object.rotation = LevelFromWorld(up).conjugate();
  }
  map.objects[2].world_from_object.rotation = Eigen::Quaterniond::Identity();
  EXPECT_LT((UpDirection(map) - up).norm(), 1e-9);
}

}  // namespace
}  // namespace deepslam::loop
