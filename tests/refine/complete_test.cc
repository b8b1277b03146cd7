#include "deepslam/refine/complete.h"

#include <vector>

#include <gtest/gtest.h>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {
namespace {

constexpr std::size_t kVoxels = std::size_t{kGridSize} * kGridSize * kGridSize;
constexpr int kGroundLayer = 4;
constexpr int kMaxGap = 5;

// A column of evidence from layer `from` to 40.
void Column(int i, int from, Evidence kind, std::vector<Evidence>& evidence) {
  for (int k = from; k < 40; ++k) evidence[VoxelGrid::Index(i, 20, k)] = kind;
}

TEST(AddMeasuredTest, LegsReachTheGroundAndArmRestsDoNot) {
  std::vector<Evidence> evidence(kVoxels, Evidence::kUnknown);
  Column(10, kGroundLayer + kMaxGap, Evidence::kSolid, evidence);      // a leg without its foot
  Column(20, kGroundLayer + kMaxGap + 1, Evidence::kSolid, evidence);  // hangs
  Column(30, kGroundLayer, Evidence::kFaint, evidence);
  Column(40, kGroundLayer, Evidence::kFree, evidence);
  std::vector<float> logits(kVoxels, -3.0F);
  logits[VoxelGrid::Index(10, 20, 30)] = 50;
  AddMeasured(evidence, kGroundLayer, kMaxGap, logits);
  const auto solid = [&](int i, int k) { return logits[VoxelGrid::Index(i, 20, k)] > 5; };
  for (int k = kGroundLayer; k < 40; ++k) EXPECT_TRUE(solid(10, k)) << k;
  EXPECT_FALSE(solid(10, kGroundLayer - 1)) << "not into the ground";
  EXPECT_TRUE(solid(20, kGroundLayer + kMaxGap + 1));
  EXPECT_FALSE(solid(20, kGroundLayer + kMaxGap));
  EXPECT_FALSE(solid(30, 20)) << "one view's word is not enough";
  EXPECT_FALSE(solid(40, 20));
  EXPECT_EQ(logits[VoxelGrid::Index(10, 20, 30)], 50) << "never less solid than before";
}

TEST(AddMeasuredTest, GroundOutsideTheGridIsItsEdge) {
  std::vector<Evidence> evidence(kVoxels, Evidence::kUnknown);
  Column(10, 2, Evidence::kSolid, evidence);
  for (const int ground : {-100, 0, 63, 1000}) {
    std::vector<float> logits(kVoxels, -3.0F);
    AddMeasured(evidence, ground, kMaxGap, logits);
    EXPECT_GT(logits[VoxelGrid::Index(10, 20, 2)], 5);
  }
}

}  // namespace
}  // namespace deepslam::refine
