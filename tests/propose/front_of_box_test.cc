#include "deepslam/propose/front_of_box.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/angles.h"
#include "deepslam/core/random.h"

namespace deepslam::propose {
namespace {

Eigen::Vector2d Turned(double yaw_rad, double x, double y) {
  return Eigen::Rotation2Dd(yaw_rad) * Eigen::Vector2d(x, y);
}

// Points of a box's faces, one per 2.5 cm with a noise of 5 mm: those at +x and +y alone.
std::vector<Eigen::Vector3f> TwoFaces(const Eigen::Vector3d& size_m, double yaw_rad) {
  Random random(5, "two faces", 0);
  std::vector<Eigen::Vector3f> points;
  const auto add = [&](double x, double y, double z) {
    const Eigen::Vector2d p = Turned(yaw_rad,
                                     0.5 * size_m.x() * x + 0.005 * random.Normal(),
                                     0.5 * size_m.y() * y + 0.005 * random.Normal());
    points.emplace_back(
        static_cast<float>(p.x() + 1), static_cast<float>(p.y() - 2), static_cast<float>(z));
  };
  for (double z = 0.0125; z < size_m.z(); z += 0.025) {
    for (double y = -1; y <= 1; y += 0.05 / size_m.y()) add(1, y, z);
    for (double x = -1; x <= 1; x += 0.05 / size_m.x()) add(x, 1, z);
  }
  return points;
}

// Between directions of sides, which repeat each quarter turn.
double ApartDeg(double a_rad, double b_rad) {
  return std::abs(kDegPerRad * std::remainder(a_rad - b_rad, 0.5 * std::numbers::pi));
}

class BoxYaw : public testing::TestWithParam<int> {};

TEST_P(BoxYaw, OfTwoFacesIsTheirs) {
  const double yaw_rad = GetParam() * kRadPerDeg;
  for (const Eigen::Vector3d& size_m : {Eigen::Vector3d(0.8, 0.9, 1.8),
                                        Eigen::Vector3d(0.6, 0.6, 0.9),
                                        Eigen::Vector3d(0.4, 1.2, 1)}) {
    const LevelBox box = MeasureBox(TwoFaces(size_m, yaw_rad));
    EXPECT_LE(ApartDeg(box.yaw_rad, yaw_rad), 2.5) << size_m.transpose();
    EXPECT_NEAR(box.size_m.head<2>().minCoeff(), size_m.head<2>().minCoeff(), 0.05);
    EXPECT_NEAR(box.size_m.head<2>().maxCoeff(), size_m.head<2>().maxCoeff(), 0.05);
    EXPECT_LT((box.center_m - Eigen::Vector2d(1, -2)).norm(), 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryTurn, BoxYaw, testing::Values(0, 20, 37, 45, 70, 88));

TEST(BoxYawOf, NoPointsIsABoxOfNothing) { EXPECT_EQ(MeasureBox({}).size_m.maxCoeff(), 0); }

// A box at the level frame's origin, which is the world's; cameras at these azimuths, 2 m off.
class FrontOfBox : public testing::Test {
 protected:
  explicit FrontOfBox(const Eigen::Vector3d& size_m = {0.6, 0.7, 1}) { box_.size_m = size_m; }

  void SeeFrom(std::initializer_list<double> azimuths_deg) {
    views_.clear();
    for (const double azimuth_deg : azimuths_deg) {
      const Eigen::Vector2d eye = Turned(azimuth_deg * kRadPerDeg, 2, 0);
      views_.emplace_back();
      views_.back().world_from_camera.translation_m = {eye.x(), eye.y(), 1.4};
    }
  }
  // A wall that the box's side of this number stands at, in a layout whose level world is turned.
  void PutWallAt(int side) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
    layout_.level_from_tracking = Pose3(turn, {3, 1, 0});
    const double half_m = 0.5 * box_.size_m[side % 2] + 0.03;
    const double yaw_rad = box_.yaw_rad + 0.5 * std::numbers::pi * side;
    const auto place = [&](double y) -> Eigen::Vector2d {
      const Eigen::Vector2d p = Turned(yaw_rad, half_m, y);
      return (layout_.level_from_tracking * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>();
    };
    LayoutWall wall;
    wall.from_m = place(-2);
    wall.to_m = place(2);
    wall.top_m = 2.5;
    layout_.walls.push_back(wall);
  }
  [[nodiscard]] int FrontSide() const {
    const FrontEvidence evidence = {views_, &layout_, turns_from_high_back_};
    return (4 - QuarterTurnsToFront(box_, Pose3(), evidence)) % 4;
  }

  LevelBox box_;
  std::vector<ObjectView> views_;
  Layout layout_;
  std::optional<int> turns_from_high_back_;
};

TEST_F(FrontOfBox, IsTheSideThatWasSeen) {
  for (int side = 0; side < 4; ++side) {
    SeeFrom({90.0 * side - 30, 90.0 * side + 10, 90.0 * side + 35});
    EXPECT_EQ(FrontSide(), side);
  }
}

TEST_F(FrontOfBox, TurnsAwayFromTheWallItStandsAt) {
  box_.yaw_rad = 0.4;
  for (int wall_side = 0; wall_side < 4; ++wall_side) {
    layout_.walls.clear();
    PutWallAt(wall_side);
    // Seen mostly from beside it.
    const double front_deg = kDegPerRad * box_.yaw_rad + 90.0 * (wall_side + 2);
    SeeFrom({front_deg + 50, front_deg + 70});
    EXPECT_EQ(FrontSide(), (wall_side + 2) % 4);
  }
}

TEST_F(FrontOfBox, OfAThinThingIsAWideSide) {
  for (const int thin : {0, 1}) {
    box_.size_m = {0.8, 0.8, 0.5};
    box_.size_m[thin] = 0.1;
    // Nearly along it: the wide side that is seen at all.
    SeeFrom({90.0 * thin + 60, 90.0 * thin + 80});
    EXPECT_EQ(FrontSide(), thin);
    SeeFrom({90.0 * thin + 120, 90.0 * thin + 100});
    EXPECT_EQ(FrontSide(), thin + 2);
  }
}

TEST_F(FrontOfBox, InACornerIsALongSide) {
  for (const int deep : {0, 1}) {
    layout_.walls.clear();
    box_.size_m = {0.5, 0.5, 0.9};
    box_.size_m[deep] = 0.65;
    PutWallAt(2);
    PutWallAt(3);
    SeeFrom({deep == 0 ? 5.0 : 85.0, 45});  // more of it from the narrow side
    EXPECT_EQ(FrontSide(), 1 - deep);
  }
}

TEST_F(FrontOfBox, IsANarrowSideWhereTheBackAloneStandsAtAWall) {
  box_.size_m = {0.7, 0.4, 0.8};  // as toilets are
  PutWallAt(2);
  SeeFrom({30, 60});
  EXPECT_EQ(FrontSide(), 0);
}

TEST_F(FrontOfBox, IsBeforeItsHighBackFromWhereverItIsSeen) {
  SeeFrom({180, 200});
  turns_from_high_back_ = 0;
  EXPECT_EQ(FrontSide(), 0);
}

TEST_F(FrontOfBox, OfNothingKnownIsSomeSide) {
  EXPECT_EQ(QuarterTurnsToFront(box_, Pose3(), {}), 0);
  box_.size_m.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_GE(FrontSide(), 0);
  EXPECT_LT(FrontSide(), 4);
}

}  // namespace
}  // namespace deepslam::propose
