#include "deepslam/registration/refine_pose.h"
#include "deepslam/core/angles.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/registration/register_shape.h"
#include "support/furniture_world.h"
#include "support/pose_matchers.h"

namespace deepslam::registration {
namespace {

using testing_support::CandidateFor;
using testing_support::FurnitureWorld;
using testing_support::Perturbed;
using testing_support::PoseNear;

constexpr double kSize_m = 0.9;

FurnitureWorld Chair() { return {testing_support::ChairGrid(), kSize_m}; }

std::vector<MeasuredView> ThreeViews() { return PrepareViews(Chair().Views({0.2, 1.0, 1.9})); }

std::vector<const MeasuredView*> Pointers(const std::vector<MeasuredView>& views) {
  std::vector<const MeasuredView*> pointers;
  for (const MeasuredView& view : views) pointers.push_back(&view);
  return pointers;
}

SimilarityIcpOptions StandingChair() {
  SimilarityIcpOptions options;
  options.min_scale_m = 0.5 * kSize_m / kModelExtent;
  options.max_scale_m = 1.5 * kSize_m / kModelExtent;
  options.ground_sigma_m = 0.01;
  return options;
}

Similarity3 Refined(const shape::ShapeModel& model,
                    const std::vector<MeasuredView>& views,
                    const Similarity3& start,
                    const SimilarityIcpOptions& options) {
  VisibleSurface visible(model);
  return RefinePose(model, visible, Pointers(views), start, options);
}

bool IsFinite(const Similarity3& pose) {
  return std::isfinite(pose.scale) && pose.scale > 0 && pose.translation_m.allFinite() &&
         pose.rotation.coeffs().allFinite();
}

TEST(RefinePose, ComesBackFromBesideTurnedAndOfAnotherSize) {
  const FurnitureWorld world = Chair();
  const Similarity3 truth = world.world_from_object();
  const std::vector<MeasuredView> views = ThreeViews();
  for (const double factor : {0.9, 1.1}) {
    for (const double towards : {0.0, 2.0, 4.0}) {
      const Similarity3 start = Perturbed(truth, factor, towards);
      const Similarity3 refined = Refined(world.model(), views, start, StandingChair());
      EXPECT_NEAR(refined.scale / truth.scale, 1.0, 0.02) << factor << ", " << towards;
      EXPECT_THAT(refined.RigidPart(), PoseNear(truth.RigidPart(), 0.015, 1.0))
          << factor << ", " << towards;
    }
  }
}

TEST(RefinePose, StaysAtTheTruth) {
  const FurnitureWorld world = Chair();
  const Similarity3 truth = world.world_from_object();
  const Similarity3 refined = Refined(world.model(), ThreeViews(), truth, StandingChair());
  EXPECT_NEAR(refined.scale / truth.scale, 1.0, 0.02);
  EXPECT_THAT(refined.RigidPart(), PoseNear(truth.RigidPart(), 0.015, 1.0));
}

// Of a back seen from behind nothing but the ground tells the height.
TEST(RefinePose, StandsOnTheGround) {
  const double yaw_rad = 0.7;
  const FurnitureWorld world(testing_support::ChairGrid(), kSize_m, yaw_rad);
  const Similarity3 truth = world.world_from_object();
  std::vector<ObjectView> seen = world.Views({yaw_rad + std::numbers::pi});
  for (int v = 0; v < seen[0].mask_crop.height(); ++v) {
    for (int u = 0; u < seen[0].mask_crop.width(); ++u) {
      const Eigen::Vector3d p_world =
          seen[0].world_from_camera * seen[0].camera.Unproject(u, v, seen[0].depth_crop_m(u, v));
      const double z_object = (truth.Inverse() * p_world).z();
      if (z_object < 0.1 || z_object > 0.4) seen[0].mask_crop(u, v) = 0;
    }
  }
  Similarity3 sunk = truth;
  sunk.translation_m.z() -= 0.04;
  SimilarityIcpOptions options = StandingChair();
  options.both_directions = false;
  options.min_scale_m = options.max_scale_m = truth.scale;
  const Similarity3 refined = Refined(world.model(), PrepareViews(seen), sunk, options);
  EXPECT_NEAR(refined.translation_m.z(), truth.translation_m.z(), 0.005);
}

TEST(RefinePose, KeepsTheScaleWithinItsBounds) {
  const FurnitureWorld world = Chair();
  SimilarityIcpOptions options = StandingChair();
  options.max_scale_m = 0.95 * world.world_from_object().scale;
  const Similarity3 refined =
      Refined(world.model(), ThreeViews(), world.world_from_object(), options);
  EXPECT_LE(refined.scale, options.max_scale_m);
  EXPECT_GE(refined.scale, 0.9 * options.max_scale_m);
}

TEST(RefinePose, SameInputSameBytes) {
  const FurnitureWorld world = Chair();
  const Similarity3 start = Perturbed(world.world_from_object(), 1.1, 1.0);
  EXPECT_EQ(Refined(world.model(), ThreeViews(), start, StandingChair()),
            Refined(world.model(), ThreeViews(), start, StandingChair()));
}

TEST(RefinePose, StaysWhereNothingCanBeMatched) {
  const FurnitureWorld world = Chair();
  SimilarityIcpOptions options = StandingChair();
  options.both_directions = false;
  Similarity3 far = world.world_from_object();
  far.translation_m.x() += 50;
  EXPECT_EQ(Refined(world.model(), ThreeViews(), far, options), far);
  EXPECT_EQ(Refined(world.model(), {}, far, options), far);
  EXPECT_EQ(Refined(shape::ShapeModel(VoxelGrid()), ThreeViews(), far, options), far);
  far.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(Refined(world.model(), ThreeViews(), far, options).translation_m.x()));
}

// Views of which only these object pixels are left.
template <typename Keep>
std::vector<MeasuredView> Thinned(std::vector<ObjectView> views, const Keep& keep) {
  for (ObjectView& view : views) {
    int n = 0;
    for (int v = 0; v < view.mask_crop.height(); ++v) {
      for (int u = 0; u < view.mask_crop.width(); ++u) {
        if (view.mask_crop(u, v) != 0 && !keep(u, v, n++)) view.mask_crop(u, v) = 0;
      }
    }
  }
  return PrepareViews(views);
}

TEST(RefinePose, StaysFiniteWithHardlyAnyPoints) {
  const FurnitureWorld world = Chair();
  const Similarity3 start = Perturbed(world.world_from_object(), 1.1, 1.0);
  const std::vector<ObjectView> one = world.Views({0.2});
  const SimilarityIcpOptions options = StandingChair();
  const auto ten = [](int, int, int n) { return n % 97 == 0 && n < 970; };
  const auto line = [](int u, int, int) { return u == 80; };
  EXPECT_TRUE(IsFinite(Refined(world.model(), PrepareViews(one), start, options)));
  EXPECT_TRUE(IsFinite(Refined(world.model(), Thinned(one, ten), start, options)));
  EXPECT_TRUE(IsFinite(Refined(world.model(), Thinned(one, line), start, options)));
  const shape::ShapeModel full(testing_support::FullGrid());
  EXPECT_TRUE(IsFinite(Refined(full, ThreeViews(), start, options)));
  Similarity3 upside_down = start;
  upside_down.rotation =
      upside_down.rotation * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  EXPECT_TRUE(IsFinite(Refined(world.model(), ThreeViews(), upside_down, options)));
}

TEST(RegisterCandidateNear, RegistersEveryViewFromTheRefinedPose) {
  const FurnitureWorld world = Chair();
  const RegisterOptions options;
  const std::vector<MeasuredView> views = PrepareForRegistration(world.Views({0.2, 1.0, 1.9}));
  const CandidateRegistration result =
      RegisterCandidateNear(CandidateFor(0.5 * kSize_m, 1.5 * kSize_m),
                            world.model(),
                            Perturbed(world.world_from_object(), 1.1, 1.0),
                            views,
                            options);
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_NEAR(result.scale_m / world.world_from_object().scale, 1.0, 0.02);
  ASSERT_EQ(result.views.size(), views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Pose3 truth =
        views[i].world_from_camera.Inverse() * world.world_from_object().RigidPart();
    ASSERT_TRUE(result.views[i].ok) << result.views[i].reason;
    EXPECT_THAT(result.views[i].camera_from_object, PoseNear(truth, 0.02, 2.0));
  }
}

TEST(RegisterCandidateNear, RefusesWhatTellsNothing) {
  const FurnitureWorld world = Chair();
  const RegisterOptions options;
  const std::vector<MeasuredView> views = ThreeViews();
  const ShapeCandidate candidate = CandidateFor(0.5, 1.5);
  const Similarity3 start = world.world_from_object();
  EXPECT_FALSE(
      RegisterCandidateNear(candidate, shape::ShapeModel(VoxelGrid()), start, views, options).ok);
  EXPECT_FALSE(RegisterCandidateNear(candidate, world.model(), start, {}, options).ok);
}

}  // namespace
}  // namespace deepslam::registration
