#include "deepslam/shape/symmetry.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"
#include "support/box_meshes.h"
#include "support/voxel_shapes.h"

namespace deepslam::shape {
namespace {

VoxelGrid Grid(const TriangleMesh& mesh) { return Voxelize(mesh).value(); }

VoxelGrid Table(float length, float width) {
  return Grid(testing_support::TableMesh(length, width, 0.75F, 0.08F));
}

VoxelGrid Chair() { return Grid(testing_support::ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.04F)); }

VoxelGrid RoundTable() {
  TriangleMesh mesh = testing_support::SphereMesh(0.6F);
  for (Eigen::Vector3f& v : mesh.vertices) v.z() *= 0.1F;
  testing_support::AddBox({-0.05F, -0.05F, -0.7F}, {0.05F, 0.05F, 0.0F}, mesh);
  return Grid(mesh);
}

TEST(Symmetry, IsReadFromTheShape) {
  EXPECT_EQ(SymmetryOf(Chair()), Symmetry::kNone);
  EXPECT_EQ(SymmetryOf(Table(1.4F, 0.8F)), Symmetry::kHalf);
  EXPECT_EQ(SymmetryOf(Table(0.9F, 0.9F)), Symmetry::kQuarter);
  EXPECT_EQ(SymmetryOf(RoundTable()), Symmetry::kAny);
  EXPECT_EQ(SymmetryOf(VoxelGrid()), Symmetry::kNone);
}

TEST(IsRound, ARoughRimIsAndABoxWithAHandleIsNot) {
  // A column of 1 m with 16 shallow grooves; a square box; the column with a shelf on one side.
  const auto grooved = [](double x, double y, double z) {
    return std::hypot(x, y) < 12 + std::cos(16 * std::atan2(y, x)) && std::abs(z) < 31;
  };
  const VoxelGrid column = testing_support::FillGrid(grooved);
  const VoxelGrid with_shelf = testing_support::FillGrid([&](double x, double y, double z) {
    return grooved(x, y, z) || (x > 0 && x < 25 && std::abs(y) < 10 && std::abs(z) < 20);
  });
  constexpr double kLimit_m = 0.01;
  const double scale_m = 1 / kModelExtent;
  EXPECT_TRUE(IsRound(ShapeModel(column), scale_m, kLimit_m));
  EXPECT_FALSE(IsRound(ShapeModel(column), 10 * scale_m, kLimit_m)) << "ten times as large";
  EXPECT_FALSE(IsRound(ShapeModel(with_shelf), scale_m, kLimit_m));
  EXPECT_FALSE(IsRound(ShapeModel(testing_support::Box(20, 20, 31)), scale_m, kLimit_m));
  EXPECT_FALSE(IsRound(ShapeModel(VoxelGrid()), scale_m, kLimit_m));
}

TEST(Symmetry, FourQuartersAreNoTurn) {
  EXPECT_EQ(TurnGrid(TurnGrid(Chair(), 3), 1), Chair());
  EXPECT_FALSE(TurnGrid(Chair(), 1) == Chair());
}

TEST(Symmetry, LeavesOfARotationWhatNoTurnOfTheShapeMakes) {
  const auto apart_deg = [](double yaw_deg, double lean_deg, Symmetry symmetry) {
    const double rad = std::numbers::pi / 180;
    return RotationApart(
               Eigen::Quaterniond(Eigen::AngleAxisd(yaw_deg * rad, Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(lean_deg * rad, Eigen::Vector3d::UnitX())),
               symmetry) /
           rad;
  };
  EXPECT_NEAR(apart_deg(170, 0, Symmetry::kNone), 170, 1e-6);
  EXPECT_NEAR(apart_deg(170, 0, Symmetry::kHalf), 10, 1e-6);
  EXPECT_NEAR(apart_deg(100, 0, Symmetry::kHalf), 80, 1e-6);
  EXPECT_NEAR(apart_deg(100, 0, Symmetry::kQuarter), 10, 1e-6);
  EXPECT_NEAR(apart_deg(45, 0, Symmetry::kAny), 0, 1e-5);
  EXPECT_NEAR(apart_deg(45, 7, Symmetry::kAny), 7, 1e-6);
  EXPECT_NEAR(apart_deg(180, 7, Symmetry::kHalf), 7, 1e-6);
}

}  // namespace
}  // namespace deepslam::shape
