#include "deepslam/instances/reach_back.h"

#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/angles.h"

namespace deepslam::instances {
namespace {

constexpr double kVoxelM = 0.04;
constexpr double kDepthM = 0.6;

// A wardrobe's front, 1 m wide and 2 m high, before a wall along x that is seen above it and at its
// sides.
class ReachBackTest : public testing::Test {
 protected:
  // Points every 2 cm from one corner of an upright rectangle to the other, across y.
  void Add(Eigen::Vector3d from_m, const Eigen::Vector3d& to_m) {
    for (double x = from_m.x(); x < to_m.x(); x += 0.02) {
      for (double z = from_m.z(); z < to_m.z(); z += 0.02) {
        points_.emplace_back(Eigen::Vector3d(x, from_m.y(), z).cast<float>());
        normals_.emplace_back(Eigen::Vector3f::UnitY());
      }
    }
  }
  void SetUp() override {
    wall_.to_m = {3, 0};
    wall_.top_m = 2.4;
    Add({1, kDepthM, 0.05}, {2, kDepthM, 2});
    Add({0, 0, 2.1}, {3, 0, 2.4});
    Add({0, 0, 0.05}, {0.9, 0, 2.1});
    Add({2.1, 0, 0.05}, {3, 0, 2.1});
  }
  [[nodiscard]] std::optional<UprightBox> Reach() const {
    const SurfaceElements elements(points_, normals_, kVoxelM);
    const std::vector<LayoutWall> walls = {wall_};
    return ReachBack(box_, facing_, walls, elements);
  }

  UprightBox box_{.centre_m = {1.5, kDepthM - 0.03},
                  .yaw_rad = 0,
                  .length_m = 1,
                  .width_m = 0.06,
                  .bottom_m = 0.05,
                  .top_m = 2};
  Eigen::Vector3f facing_ = 500 * Eigen::Vector3f::UnitY();
  LayoutWall wall_;

 private:
  std::vector<Eigen::Vector3f> points_;
  std::vector<Eigen::Vector3f> normals_;
};

TEST_F(ReachBackTest, AFrontIsAsDeepAsTheWallBehindItLets) {
  const std::optional<UprightBox> whole = Reach();
  ASSERT_TRUE(whole);
  EXPECT_NEAR(whole->width_m, kDepthM, 1e-9);
  EXPECT_NEAR(whole->centre_m.y(), kDepthM / 2, 1e-9);
  EXPECT_EQ(whole->centre_m.x(), 1.5);
  EXPECT_EQ(whole->length_m, 1);
  EXPECT_EQ(whole->top_m, 2);
}

TEST_F(ReachBackTest, ABoxMayLieAcrossItsAxes) {
  std::swap(box_.length_m, box_.width_m);
  box_.yaw_rad = 90 * kRadPerDeg;
  const std::optional<UprightBox> whole = Reach();
  ASSERT_TRUE(whole);
  EXPECT_NEAR(whole->length_m, kDepthM, 1e-9);
  EXPECT_EQ(whole->width_m, 1);
}

TEST_F(ReachBackTest, NotWhereTheWallBehindWasSeen) {
  Add({1, 0, 0.5}, {2, 0, 1.0});  // past an open leaf, or a screen
  EXPECT_FALSE(Reach());
}

TEST_F(ReachBackTest, BelowWhatHangsTheWallMayBeSeen) {
  box_.bottom_m = 1.4;
  Add({1, 0, 0.9}, {2, 0, 1.42});
  EXPECT_TRUE(Reach());
  box_.bottom_m = 1.2;
  EXPECT_FALSE(Reach());
}

TEST_F(ReachBackTest, NotWhereSomethingStandsBetween) {
  Add({1.2, 0.3, 0.05}, {1.8, 0.3, 0.6});
  EXPECT_FALSE(Reach());
}

TEST_F(ReachBackTest, NotWhereTheWallEndsWithIt) {
  wall_.top_m = 2.05;
  EXPECT_FALSE(Reach());
}

TEST_F(ReachBackTest, NotAcrossARoomNorAtTheWallItself) {
  box_.centre_m.y() = 1.2;
  EXPECT_FALSE(Reach());
  box_.centre_m.y() = 0.08;
  EXPECT_FALSE(Reach());
}

TEST_F(ReachBackTest, NotWhereItFacesTheWallOrAnotherWay) {
  facing_ = -facing_;
  EXPECT_FALSE(Reach());
  facing_ = 500 * Eigen::Vector3f::UnitX();
  EXPECT_FALSE(Reach());
  facing_ = 500 * Eigen::Vector3f::UnitY();
  box_.yaw_rad = 20 * kRadPerDeg;
  EXPECT_FALSE(Reach());
}

TEST_F(ReachBackTest, NotBesideAWallNorWithoutOne) {
  wall_.to_m = {1.2, 0};
  EXPECT_FALSE(Reach());
  wall_.to_m = wall_.from_m;
  EXPECT_FALSE(Reach());
  EXPECT_FALSE(ReachBack(box_, facing_, {}, SurfaceElements({}, {}, kVoxelM)));
}

}  // namespace
}  // namespace deepslam::instances
