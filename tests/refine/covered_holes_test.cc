#include "deepslam/refine/covered_holes.h"

#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

namespace deepslam::refine {
namespace {

bool Never(std::size_t) { return false; }

// A column of voxels from layer 30 to 32 on every cell of a rectangle.
void Set(Eigen::Array2i low, Eigen::Array2i end, std::uint8_t value, VoxelGrid& grid) {
  for (int i = low.x(); i < end.x(); ++i) {
    for (int j = low.y(); j < end.y(); ++j) {
      for (int k = 30; k < 33; ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = value;
    }
  }
}

// A plate of 40 x 30 voxels, three high.
VoxelGrid Plate() {
  VoxelGrid grid;
  Set({10, 15}, {50, 45}, 1, grid);
  return grid;
}

void Cut(int i_end, int j_end, VoxelGrid& grid) { Set({20, 20}, {i_end, j_end}, 0, grid); }

TEST(FillCoveredHoles, FillsWhatNoRayWentThrough) {
  VoxelGrid grid = Plate();
  Cut(28, 26, grid);
  FillCoveredHoles(Never, grid);
  EXPECT_EQ(grid.occupied, Plate().occupied);
}

TEST(FillCoveredHoles, LeavesHolesThatRaysWentThrough) {
  VoxelGrid grid = Plate();
  Cut(28, 26, grid);
  FillCoveredHoles([](std::size_t n) { return n == VoxelGrid::Index(22, 22, 31); }, grid);
  EXPECT_FALSE(grid.At(21, 21, 31));
  EXPECT_TRUE(grid.At(21, 21, 30)) << "a layer of its own";
  FillCoveredHoles(Never, grid);
  EXPECT_EQ(grid.occupied, Plate().occupied);
}

TEST(FillCoveredHoles, LeavesWhatIsInsideAFrame) {
  VoxelGrid grid = Plate();
  Cut(40, 40, grid);
  const VoxelGrid before = grid;
  FillCoveredHoles(Never, grid);
  EXPECT_EQ(grid.occupied, before.occupied);
}

TEST(FillCoveredHoles, LeavesNotchesAtTheEdgeAndNarrowLayers) {
  VoxelGrid grid = Plate();
  for (int i = 10; i < 14; ++i) grid.occupied[VoxelGrid::Index(i, 20, 31)] = 0;
  for (const int i : {10, 49}) {  // two legs, one hollow
    for (int k = 0; k < 30; ++k) grid.occupied[VoxelGrid::Index(i, 15, k)] = 1;
  }
  const VoxelGrid before = grid;
  FillCoveredHoles(Never, grid);
  EXPECT_EQ(grid.occupied, before.occupied);
}

TEST(FillCoveredHoles, OfNothingIsNothing) {
  VoxelGrid grid;
  FillCoveredHoles(Never, grid);
  EXPECT_EQ(grid.occupied, VoxelGrid().occupied);
}

}  // namespace
}  // namespace deepslam::refine
