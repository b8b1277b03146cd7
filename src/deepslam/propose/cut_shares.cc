#include "deepslam/propose/cut_shares.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>

#include "deepslam/core/check.h"
#include "deepslam/shape/small_components.h"

namespace deepslam::propose {
namespace {

constexpr float kLeastShare = 0.05F;  // less likely voxels are free in any layer
// Parts of a leg may lie a voxel apart.
constexpr int kReach = 2;
constexpr double kNoiseShare = 0.003;  // of all solid voxels: smaller components are noise

// The value above which the voxels of a layer are solid.
float LevelOfLayer(std::span<const float> shares, int k, const SolidCut& cut) {
  std::array<float, std::size_t{kGridSize} * kGridSize> layer{};
  double expected = 0;
  for (std::size_t n = 0; n < layer.size(); ++n) {
    layer.at(n) = shares[n * kGridSize + static_cast<std::size_t>(k)];
    expected += static_cast<double>(layer.at(n));
  }
  const auto kept =
      std::min(layer.size() - 1, static_cast<std::size_t>(cut.kept_of_expected * expected + 0.5));
  const auto first_left_out = layer.begin() + static_cast<std::ptrdiff_t>(kept);
  std::nth_element(layer.begin(), first_left_out, layer.end(), std::greater<>());
  return std::min(static_cast<float>(cut.threshold), std::max(kLeastShare, *first_left_out));
}

}  // namespace

VoxelGrid CutShares(std::span<const float> shares, const SolidCut& cut) {
  VoxelGrid solid;
  DEEPSLAM_CHECK(shares.size() == solid.occupied.size(), "a share for each voxel");
  for (int k = 0; k < kGridSize; ++k) {
    const float level = LevelOfLayer(shares, k, cut);
    for (std::size_t n = static_cast<std::size_t>(k); n < shares.size(); n += kGridSize)
      solid.occupied[n] = shares[n] > level ? 1 : 0;
  }
  return shape::WithoutSmallComponents(solid, kReach, kNoiseShare);
}

}  // namespace deepslam::propose
