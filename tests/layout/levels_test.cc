#include "deepslam/layout/levels.h"

#include <vector>

#include <gtest/gtest.h>

namespace deepslam::layout {
namespace {

// Level squares in a surface that cameras were carried through.
class Squares {
 public:
  Squares() { surface_.has_ground = true; }

  void Add(const Eigen::Vector2d& centre_m, double side_m, double height_m) {
    constexpr double kStep_m = 0.04;
    SurfacePlane plane;
    plane.plane = {Eigen::Vector3d::UnitZ(), -height_m};
    plane.centre_m = {centre_m.x(), centre_m.y(), height_m};
    plane.area_m2 = side_m * side_m;
    for (double x = -0.5 * side_m; x <= 0.5 * side_m; x += kStep_m) {
      for (double y = -0.5 * side_m; y <= 0.5 * side_m; y += kStep_m) {
        plane.vertices.push_back(static_cast<std::uint32_t>(surface_.mesh.vertices.size()));
        surface_.mesh.vertices.emplace_back(
            (plane.centre_m + Eigen::Vector3d(x, y, 0)).cast<float>());
      }
    }
    planes_.push_back(plane);
  }
  // A camera every 10 cm along y = 0.
  void Walk(double from_x_m, double to_x_m, double height_m) {
    for (double x = from_x_m; x <= to_x_m; x += 0.1)
      surface_.viewpoints.emplace_back(static_cast<float>(x), 0.0F, static_cast<float>(height_m));
  }
  [[nodiscard]] std::vector<double> FloorHeights_m() const {
    std::vector<double> heights;
    for (const LayoutLevel& level : FindLevels(surface_, planes_)) {
      if (level.kind == LevelKind::kFloor) heights.push_back(level.height_m);
    }
    return heights;
  }

 private:
  CoarseSurface surface_;
  std::vector<SurfacePlane> planes_;
};

TEST(FindLevels, ABedThatSomebodyReachesOverIsNoFloor) {
  Squares squares;
  squares.Add({0, 0}, 5, 0);
  squares.Add({1.5, 0.6}, 1.4, 0.5);
  squares.Walk(-2, 2, 1.5);  // along the bed, the camera over its edge
  EXPECT_EQ(squares.FloorHeights_m(), (std::vector<double>{0.0}));
}

TEST(FindLevels, AStepIsAFloorWhereCamerasRiseByIt) {
  for (const double step_m : {0.18, 0.45, 1.0}) {
    Squares squares;
    squares.Add({0, 0}, 4, 0);
    squares.Add({3, 0}, 2, step_m);
    squares.Walk(-2, 1.5, 1.5);
    squares.Walk(2.2, 3.5, 1.5 + step_m);
    EXPECT_EQ(squares.FloorHeights_m(), (std::vector<double>{0.0, step_m}));
  }
}

TEST(FindLevels, WhatLiesOnTheGroundIsAFloorWhereItIsLarge) {
  Squares squares;
  squares.Add({0, 0}, 4, 0.01);
  squares.Add({1, 1}, 0.4, 0.095);  // the foot of a shelf
  EXPECT_EQ(squares.FloorHeights_m(), (std::vector<double>{0.01}));
  squares.Add({-1, -1}, 1.0, 0.095);  // a platform
  EXPECT_EQ(squares.FloorHeights_m(), (std::vector<double>{0.01, 0.095}));
}

}  // namespace
}  // namespace deepslam::layout
