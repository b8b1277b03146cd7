#include "deepslam/library/mirrored.h"

#include <gtest/gtest.h>

#include "deepslam/shape/stretch.h"

namespace deepslam::library {
namespace {

void Fill(VoxelGrid& grid, const Eigen::Vector3i& first, const Eigen::Vector3i& last) {
  for (int x = first.x(); x <= last.x(); ++x) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int z = first.z(); z <= last.z(); ++z) grid.occupied[VoxelGrid::Index(x, y, z)] = 1;
    }
  }
}

// A seat with its back at the far side, left and right alike.
VoxelGrid Sofa() {
  VoxelGrid grid;
  Fill(grid, {20, 1, 20}, {43, 62, 30});
  Fill(grid, {20, 1, 31}, {25, 62, 43});
  return grid;
}

// A long seat at the left as well.
VoxelGrid CornerSofa() {
  VoxelGrid grid = Sofa();
  Fill(grid, {44, 45, 20}, {60, 62, 30});
  return grid;
}

TEST(Mirrored, ExchangesLeftAndRightAndNothingElse) {
  const LibraryModel corner{
      "a/corner", "Corner", "sofa", {1, 2, 0.8}, "M", "CC0", CornerSofa(), "c"};
  const LibraryModel mirrored = Mirrored(corner);
  EXPECT_EQ(mirrored.id, "a/corner-mirrored");
  EXPECT_EQ(mirrored.class_name, "sofa");
  EXPECT_EQ(mirrored.size_m, corner.size_m);
  EXPECT_EQ(mirrored.creator, "M");
  EXPECT_TRUE(mirrored.checksum.empty()) << "of another shape";
  EXPECT_EQ(mirrored.shape.occupied[VoxelGrid::Index(50, 63 - 50, 25)], 1);
  EXPECT_EQ(mirrored.shape.occupied[VoxelGrid::Index(50, 50, 25)], 0);
  EXPECT_EQ(Mirrored(mirrored).shape.occupied, corner.shape.occupied);
}

TEST(Mirrored, OnlyWhatIsMadeForOneHandIsAdded) {
  EXPECT_FALSE(HasAHand(Sofa()));
  EXPECT_TRUE(HasAHand(CornerSofa()));
  EXPECT_FALSE(HasAHand(VoxelGrid()));
  // A leg that rounding put one voxel off its twin is no hand.
  VoxelGrid rounded;
  Fill(rounded, {20, 1, 40}, {43, 62, 42});
  Fill(rounded, {20, 2, 20}, {21, 3, 39});
  Fill(rounded, {20, 61, 20}, {21, 62, 39});
  EXPECT_FALSE(HasAHand(rounded));
  std::vector<LibraryModel> models(2);
  models[0].id = "a/sofa";
  models[0].shape = Sofa();
  models[1].id = "a/corner";
  models[1].shape = CornerSofa();
  AddMirrored(models);
  ASSERT_EQ(models.size(), 3u);
  EXPECT_EQ(models[2].id, "a/corner-mirrored");
}

}  // namespace
}  // namespace deepslam::library
