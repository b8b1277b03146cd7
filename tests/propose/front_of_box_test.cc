#include "deepslam/propose/front_of_box.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/angles.h"

namespace deepslam::propose {
namespace {

Eigen::Vector2d Turned(double yaw_rad, double x, double y) {
  return Eigen::Rotation2Dd(yaw_rad) * Eigen::Vector2d(x, y);
}

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
