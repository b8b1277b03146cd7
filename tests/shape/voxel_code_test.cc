#include "deepslam/shape/voxel_code.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/shape/binvox.h"
#include "support/voxel_shapes.h"

namespace deepslam::shape {
namespace {

using namespace testing_support;  // NOLINT(google-build-using-namespace)

// A sofa as a fusion of noisy depth has it.
VoxelGrid BumpySofa() {
  return FillGrid([](double x, double y, double z) {
    const double bump = 1.2 * std::sin(0.5 * x) * std::cos(0.6 * y) * std::sin(0.5 * z);
    return std::abs(x) < 16 + bump && std::abs(y) < 30 + bump && std::abs(z) < 16 + bump &&
           !(x > 0 && z > 2 && std::abs(y) < 24);
  });
}

VoxelGrid Noise(double share, std::uint64_t seed) {
  Random random(seed);
  VoxelGrid grid;
  for (std::uint8_t& voxel : grid.occupied) voxel = random.Uniform() < share ? 1 : 0;
  return grid;
}

TEST(VoxelCode, GivesTheVeryVoxelsBack) {
  VoxelGrid full;
  std::fill(full.occupied.begin(), full.occupied.end(), std::uint8_t{1});
  VoxelGrid last;
  last.occupied.back() = 1;
  for (const VoxelGrid& grid : {VoxelGrid(), full, last, BumpySofa(), ChairWithThinLegs(),
                                Noise(0.001, 1), Noise(0.5, 2), Noise(0.9, 3)}) {
    const std::string bytes = EncodeVoxels(grid);
    const Result<VoxelGrid> decoded = DecodeVoxels(bytes);
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    EXPECT_EQ(decoded->occupied, grid.occupied);
    EXPECT_EQ(EncodeVoxels(grid), bytes);
  }
}

// Entropy of the surface's bends, not of the volume: what maps count on.
TEST(VoxelCode, FurnitureTakesAboutAKilobyte) {
  EXPECT_LT(EncodeVoxels(Box(30, 12, 18)).size(), 200U);
  EXPECT_LT(EncodeVoxels(ChairWithThinLegs()).size(), 400U);
  EXPECT_LT(EncodeVoxels(BumpySofa()).size(), 1100U);
  // What says nothing costs a bit a voxel, and little more.
  EXPECT_LT(EncodeVoxels(Noise(0.5, 4)).size(), 1.05 * kGridSize * kGridSize * kGridSize / 8);
}

TEST(VoxelCode, RefusesWhatIsDamaged) {
  const std::string bytes = EncodeVoxels(BumpySofa());
  for (std::size_t length = 0; length < bytes.size(); length += 7)
    EXPECT_FALSE(DecodeVoxels(bytes.substr(0, length)).ok()) << length;
  EXPECT_FALSE(DecodeVoxels(bytes + "more than there was").ok());
  EXPECT_FALSE(DecodeVoxels(std::string(1 << 20, 'x')).ok());
  Random random(5);
  for (int n = 0; n < 100; ++n) {
    std::string damaged = bytes;
    damaged[random.Index(damaged.size())] ^= static_cast<char>(1 + random.Index(255));
    EXPECT_FALSE(DecodeVoxels(damaged).ok()) << n;
    std::string foreign(random.Index(2000), '\0');
    for (char& c : foreign) c = static_cast<char>(random.Index(256));
    EXPECT_FALSE(DecodeVoxels(foreign).ok()) << n;
  }
}

}  // namespace
}  // namespace deepslam::shape
