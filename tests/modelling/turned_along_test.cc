#include "deepslam/modelling/turned_along.h"

#include <cmath>

#include <gtest/gtest.h>

#include "deepslam/core/angles.h"

namespace deepslam::modelling {
namespace {

// Upright in a world whose vertical is y, as that of the first camera may be.
Pose3 Standing(double yaw_deg) {
  const Eigen::AngleAxisd upright(-90 * kRadPerDeg, Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd yaw(yaw_deg * kRadPerDeg, Eigen::Vector3d::UnitZ());
  return Pose3(Eigen::Quaterniond(upright * yaw), {1, 2, 3});
}

double ApartDeg(const Pose3& a, const Pose3& b) {
  return kDegPerRad * a.rotation.angularDistance(b.rotation);
}

TEST(TurnedAlong, MakesSidesParallelWhicheverSideIsTheFront) {
  for (const double quarter_deg : {0, 90, 180, 270}) {
    for (const double off_deg : {-8, -3, 4, 9}) {
      const Pose3 turned = TurnedAlong(Standing(25), Standing(25 + off_deg + quarter_deg));
      EXPECT_LT(ApartDeg(turned, Standing(25 + off_deg)), 1e-6) << off_deg << " " << quarter_deg;
      EXPECT_EQ(turned.translation_m, Standing(25).translation_m);
    }
  }
}

TEST(TurnedAlong, LeavesWhatIsNearlyParallelAndWhatIsNoSideOfIt) {
  for (const double off_deg : {0, 1, -1, 15, 30, 45, -20}) {
    const Pose3 turned = TurnedAlong(Standing(25), Standing(25 + off_deg));
    EXPECT_LT(ApartDeg(turned, Standing(25)), 1e-6) << off_deg;
  }
}

}  // namespace
}  // namespace deepslam::modelling
