#include "deepslam/refine/refine_latents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {
namespace {

using testing::HasSubstr;

constexpr std::size_t kVoxels = std::size_t{kGridSize} * kGridSize * kGridSize;
constexpr int kSlab = 16;  // voxels along x that one latent turns on and off
constexpr float kGain = 4;

std::size_t SlabOf(std::size_t voxel) { return voxel / (kGridSize * kGridSize) / kSlab; }

// Four latents, each the logit of a slab.
Decoder Slabs() {
  return {[](std::span<const float> latents) -> Result<std::vector<float>> {
            std::vector<float> logits(kVoxels);
            for (std::size_t n = 0; n < kVoxels; ++n) logits[n] = kGain * latents[SlabOf(n)];
            return logits;
          },
          [](std::span<const float> latents,
             std::span<const float> by_logits) -> Result<std::vector<float>> {
            std::vector<double> sums(latents.size(), 0.0);
            for (std::size_t n = 0; n < kVoxels; ++n)
              sums[SlabOf(n)] += kGain * static_cast<double>(by_logits[n]);
            return std::vector<float>(sums.begin(), sums.end());
          }};
}

std::vector<Evidence> SlabEvidence(const std::array<Evidence, 4>& slabs) {
  std::vector<Evidence> evidence(kVoxels);
  for (std::size_t n = 0; n < kVoxels; ++n) evidence[n] = slabs.at(SlabOf(n));
  return evidence;
}

const std::vector<float> kStart = {-0.5F, 0.6F, 0.2F, -0.3F};

RefineOptions Light() {
  RefineOptions options;
  options.prior_weight = 0.01;
  return options;
}

TEST(RefineLatentsTest, FollowsWhatWasSeenAndKeepsWhatWasNot) {
  const auto evidence =
      SlabEvidence({Evidence::kUnknown, Evidence::kFree, Evidence::kSolid, Evidence::kFaint});
  const Result<RefinedLatents> refined = RefineLatents(kStart, evidence, Slabs(), Light());
  ASSERT_TRUE(refined) << refined.error().message;
  EXPECT_NEAR(refined->latents[0], kStart[0], 1e-4F);
  EXPECT_LT(refined->latents[1], -0.5F);
  EXPECT_GT(refined->latents[2], 0.5F);
  EXPECT_GT(refined->latents[3], 0.5F) << "faint is solid enough to be followed";
  EXPECT_LT(refined->loss, 0.5 * refined->initial_loss);
}

TEST(RefineLatentsTest, IsTheSameEveryTime) {
  const auto evidence =
      SlabEvidence({Evidence::kSolid, Evidence::kFree, Evidence::kFree, Evidence::kSolid});
  const Result<RefinedLatents> first = RefineLatents(kStart, evidence, Slabs(), Light());
  const Result<RefinedLatents> second = RefineLatents(kStart, evidence, Slabs(), Light());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->latents, second->latents);
}

TEST(RefineLatentsTest, AHeavyPriorStaysNearTheStart) {
  const auto evidence =
      SlabEvidence({Evidence::kSolid, Evidence::kFree, Evidence::kUnknown, Evidence::kUnknown});
  const auto way = [&](double weight) {
    RefineOptions options;
    options.prior_weight = weight;
    const Result<RefinedLatents> refined = RefineLatents(kStart, evidence, Slabs(), options);
    EXPECT_TRUE(refined);
    return std::abs(refined->latents[0] - kStart[0]);
  };
  EXPECT_GT(way(0.01), way(10));
  EXPECT_GT(way(10), way(1000));
  EXPECT_LT(way(1e3), 0.1);
}

// A voxel beside a solid one speaks neither against the shape nor does it have to be empty.
TEST(RefineLatentsTest, OneVoxelBesideTheMeasuredIsNoFault) {
  std::vector<Evidence> evidence(kVoxels, Evidence::kUnknown);
  for (int j = 0; j < kGridSize; ++j) {
    for (int k = 0; k < kGridSize; ++k) {
      evidence[VoxelGrid::Index(kSlab - 1, j, k)] = Evidence::kFree;
      evidence[VoxelGrid::Index(kSlab, j, k)] = Evidence::kSolid;  // in the next slab
    }
  }
  const std::vector<float> shown = {1, -1, -1, -1};
  const Result<RefinedLatents> refined = RefineLatents(shown, evidence, Slabs(), Light());
  ASSERT_TRUE(refined);
  EXPECT_GT(refined->latents[0], 0.9F) << "the shape ends one voxel short of the measured";
  EXPECT_NEAR(refined->latents[1], -1, 1e-4F);
}

TEST(RefineLatentsTest, StopsAfterItsEvaluations) {
  int count = 0;
  Decoder counting = Slabs();
  counting.logits = [&count, slabs = Slabs()](std::span<const float> latents) {
    ++count;
    return slabs.logits(latents);
  };
  RefineOptions options = Light();
  options.max_evaluations = 3;
  const auto evidence =
      SlabEvidence({Evidence::kSolid, Evidence::kFree, Evidence::kFree, Evidence::kSolid});
  EXPECT_TRUE(RefineLatents(kStart, evidence, counting, options));
  EXPECT_LE(count, 3);
}

TEST(RefineLatentsTest, SaysWhyItCannot) {
  const auto seen =
      SlabEvidence({Evidence::kSolid, Evidence::kFree, Evidence::kFree, Evidence::kFree});
  const std::vector<Evidence> blind(kVoxels, Evidence::kFree);
  const Result<RefinedLatents> nothing = RefineLatents(kStart, blind, Slabs(), Light());
  ASSERT_FALSE(nothing);
  EXPECT_THAT(nothing.error().message, HasSubstr("refine.min_voxels"));
  const std::vector<float> wild = {1, std::numeric_limits<float>::infinity(), 0, 0};
  EXPECT_FALSE(RefineLatents(wild, seen, Slabs(), Light()));
  EXPECT_FALSE(RefineLatents({}, seen, Slabs(), Light()));
  Decoder broken = Slabs();
  broken.latent_gradient = [](std::span<const float>, std::span<const float>) {
    return Result<std::vector<float>>(Failed("the decoder is broken"));
  };
  const Result<RefinedLatents> failed = RefineLatents(kStart, seen, broken, Light());
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().message, HasSubstr("the decoder is broken"));
}

}  // namespace
}  // namespace deepslam::refine
