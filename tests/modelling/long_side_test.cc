#include "deepslam/modelling/long_side.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::modelling {
namespace {

// A board of so many voxels in the grid's middle, with a drawer at one end of x and a side of y, so
// that no two ways of turning it are alike; where it stands in some model's frame.
refine::CompletedModel Board(int along_x, int along_y) {
  refine::CompletedModel model;
  const int i0 = (kGridSize - along_x) / 2, j0 = (kGridSize - along_y) / 2;
  for (int i = 0; i < along_x; ++i) {
    for (int j = 0; j < along_y; ++j) {
      model.grid.occupied[VoxelGrid::Index(i0 + i, j0 + j, 40)] = 1;
      if (i < 5 && j < 3) model.grid.occupied[VoxelGrid::Index(i0 + i, j0 + j, 39)] = 1;
    }
  }
  model.model_from_grid = {
      0.8, Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())), {0.1, 0.2, 0.05}};
  return model;
}

std::vector<Eigen::Vector3d> PlacesOf(const refine::CompletedModel& model) {
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k)
        if (model.grid.At(i, j, k))
          places.push_back(model.model_from_grid * VoxelGrid::Center(i, j, k));
    }
  }
  return places;
}

double FarthestApart(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  double farthest = 0;
  for (const Eigen::Vector3d& p : a) {
    double nearest = 1e9;
    for (const Eigen::Vector3d& q : b) nearest = std::min(nearest, (p - q).norm());
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

TEST(FaceAcrossLongSide, NamesTheAxesAndMovesNothing) {
  const refine::CompletedModel before = Board(60, 40);
  refine::CompletedModel after = before;
  FaceAcrossLongSide(after);
  const Eigen::Array3i sides = OccupiedBox(after.grid)->sides();
  EXPECT_EQ(sides.x(), 40);
  EXPECT_EQ(sides.y(), 60);
  EXPECT_EQ(PlacesOf(after).size(), PlacesOf(before).size());
  EXPECT_LT(FarthestApart(PlacesOf(before), PlacesOf(after)), 1e-9);
}

TEST(FaceAcrossLongSide, LeavesWhatDoesSoOrIsNearlySquareOrNothing) {
  for (refine::CompletedModel model : {Board(40, 60), Board(60, 57), refine::CompletedModel()}) {
    const refine::CompletedModel before = model;
    FaceAcrossLongSide(model);
    EXPECT_EQ(model.grid, before.grid);
    EXPECT_EQ(model.model_from_grid, before.model_from_grid);
  }
}

}  // namespace
}  // namespace deepslam::modelling
