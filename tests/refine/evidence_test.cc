#include "deepslam/refine/evidence.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/shape/shape_model.h"
#include "support/staged_views.h"
#include "support/voxel_shapes.h"

namespace deepslam::refine {
namespace {

using testing_support::Box;
using testing_support::LookAt;
using testing_support::Staged;

class EvidenceTest : public testing::Test {
 protected:
  void Stage(int count) {
    for (int n = 0; n < count; ++n)
      staged_.push_back(LookAt(model_, 0.3 + 2 * std::numbers::pi * n / count));
  }

  [[nodiscard]] std::vector<Evidence> Carve() const {
    std::vector<PlacedView> placed;
    for (const Staged& staged : staged_) placed.push_back({&staged.view, staged.camera_from_grid});
    return CarveEvidence(placed);
  }

  // How many voxels of a kind lie further inside, or outside, the model than `voxels`.
  [[nodiscard]] int CountBeyond(const std::vector<Evidence>& evidence,
                                Evidence kind,
                                double voxels,
                                bool inside) const {
    int count = 0;
    for (int i = 0; i < kGridSize; ++i) {
      for (int j = 0; j < kGridSize; ++j) {
        for (int k = 0; k < kGridSize; ++k) {
          const double distance = model_.DistanceAt(i, j, k) / kVoxelSize;
          if (evidence[VoxelGrid::Index(i, j, k)] == kind &&
              (inside ? distance < -voxels : distance > voxels))
            ++count;
        }
      }
    }
    return count;
  }

  shape::ShapeModel model_{Box(14, 18, 22)};
  std::vector<Staged> staged_;
};

TEST_F(EvidenceTest, SurfaceIsSolidAirIsFreeAndTheInsideUnknown) {
  Stage(8);
  const std::vector<Evidence> evidence = Carve();
  EXPECT_GT(std::count(evidence.begin(), evidence.end(), Evidence::kSolid), 2000);
  EXPECT_EQ(CountBeyond(evidence, Evidence::kSolid, 2, false), 0);
  EXPECT_EQ(CountBeyond(evidence, Evidence::kSolid, 4, true), 0) << "a shell";
  EXPECT_EQ(CountBeyond(evidence, Evidence::kFree, 1.5, true), 0);
  EXPECT_EQ(evidence[VoxelGrid::Index(32, 32, 32)], Evidence::kUnknown);
  EXPECT_EQ(evidence[VoxelGrid::Index(3, 3, 32)], Evidence::kFree);
}

TEST_F(EvidenceTest, OneViewOutOfPlaceIsOutvoted) {
  Stage(8);
  const std::vector<Evidence> sound = Carve();
  staged_[3].camera_from_grid.translation_m += Eigen::Vector3d(0.1, 0, 0.1);
  const std::vector<Evidence> disturbed = Carve();
  int lost = 0;
  for (std::size_t n = 0; n < sound.size(); ++n)
    lost += sound[n] == Evidence::kSolid && disturbed[n] != Evidence::kSolid ? 1 : 0;
  EXPECT_LT(lost,
            0.35 * static_cast<double>(std::count(sound.begin(), sound.end(), Evidence::kSolid)));
  EXPECT_LT(CountBeyond(disturbed, Evidence::kSolid, 3, false), 20) << "no ghost beside it";
}

// Noise of depth lies along the ray; at low angles little of it is across the surface: here the
// middle of the top layer is half a voxel before what was measured, and a fifth of one above it.
TEST_F(EvidenceTest, RaysThatGrazeATopMakeNoPitsInIt) {
  constexpr double kElevation_rad = 0.4;
  for (int n = 0; n < 4; ++n) staged_.push_back(LookAt(model_, 0.3 + n, kElevation_rad));
  std::vector<PlacedView> placed;
  for (Staged& staged : staged_) {
    const auto too_far_m = static_cast<float>(1.8 * kVoxelSize * staged.camera_from_grid.scale);
    DepthImage& depth_m = staged.view.depth_crop_m;
    for (std::size_t p = 0; p < depth_m.size(); ++p) depth_m.data()[p] += too_far_m;
    placed.push_back({&staged.view, staged.camera_from_grid});
  }
  const std::vector<Votes> votes =
      CountVotes(placed, std::vector<std::uint8_t>(VoxelGrid().occupied.size(), 1));
  const int top = OccupiedBox(Box(14, 18, 22))->high.z();
  int num_grazed = 0;
  for (int i = -8; i <= 8; ++i) {
    const Votes& in_top = votes[VoxelGrid::Index(kGridSize / 2 + i, kGridSize / 2, top)];
    EXPECT_FALSE(in_top.IsFree()) << i;
    num_grazed += in_top.grazed > 0 ? 1 : 0;
    EXPECT_TRUE(votes[VoxelGrid::Index(kGridSize / 2 + i, kGridSize / 2, top + 3)].IsFree()) << i;
  }
  EXPECT_GT(num_grazed, 8) << "most rays pass the middle of the layer that they measure";
}

TEST_F(EvidenceTest, WhatOneOfSeveralSawIsFaint) {
  Stage(2);
  const std::vector<Evidence> of_two = Carve();
  EXPECT_GT(std::count(of_two.begin(), of_two.end(), Evidence::kFaint), 500);
  staged_.pop_back();
  const std::vector<Evidence> of_one = Carve();
  EXPECT_EQ(std::count(of_one.begin(), of_one.end(), Evidence::kFaint), 0);
  EXPECT_GT(std::count(of_one.begin(), of_one.end(), Evidence::kSolid), 500);
}

TEST_F(EvidenceTest, ViewsThatCannotBeSaySoByNothing) {
  Stage(1);
  const auto says_nothing = [&](const Staged& staged) {
    const PlacedView placed = {&staged.view, staged.camera_from_grid};
    const std::vector<Evidence> evidence = CarveEvidence({&placed, 1});
    return std::all_of(
        evidence.begin(), evidence.end(), [](Evidence e) { return e == Evidence::kUnknown; });
  };
  EXPECT_FALSE(says_nothing(staged_[0]));
  Staged blind = staged_[0];
  blind.view.depth_crop_m = DepthImage();
  EXPECT_TRUE(says_nothing(blind));
  Staged uneven = staged_[0];
  uneven.view.mask_crop = Mask(3, 3);
  EXPECT_TRUE(says_nothing(uneven));
  Staged nowhere = staged_[0];
  nowhere.camera_from_grid.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(says_nothing(nowhere));
  Staged behind = staged_[0];
  behind.camera_from_grid.translation_m.z() = -5;
  EXPECT_TRUE(says_nothing(behind));
  Staged torn = staged_[0];
  for (float& depth_m : torn.view.depth_crop_m) depth_m = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(says_nothing(torn));
  const std::vector<Evidence> of_none = CarveEvidence({});
  EXPECT_EQ(std::count(of_none.begin(), of_none.end(), Evidence::kUnknown),
            kGridSize * kGridSize * kGridSize);
}

}  // namespace
}  // namespace deepslam::refine
