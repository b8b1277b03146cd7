#include "deepslam/registration/register_shape.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/furniture_world.h"
#include "support/pose_matchers.h"

namespace deepslam::registration {
namespace {

using testing_support::CandidateFor;
using testing_support::FurnitureWorld;
using testing_support::PoseNear;
using testing_support::ViewSettings;

// The project's measure of a placement worth having.
constexpr double kPositionTolerance = 0.05;  // m
constexpr double kAngleTolerance = 10;       // deg
constexpr double kScaleTolerance = 0.05;     // relative

std::vector<double> Around(int count, double from_rad, double to_rad) {
  std::vector<double> azimuths;
  for (int i = 0; i < count; ++i) {
    azimuths.push_back(from_rad + (to_rad - from_rad) * i / std::max(1, count - 1));
  }
  return azimuths;
}

void ExpectFinite(const CandidateRegistration& registration) {
  EXPECT_TRUE(std::isfinite(registration.scale_m));
  EXPECT_TRUE(registration.world_from_object.Matrix().allFinite());
  for (const ViewRegistration& view : registration.views) {
    EXPECT_TRUE(view.camera_from_object.Matrix().allFinite());
    EXPECT_TRUE(view.information.allFinite());
    EXPECT_TRUE(std::isfinite(view.rmse_m) && std::isfinite(view.inlier_share));
  }
}

void ExpectRefused(const CandidateRegistration& registration, std::size_t num_views) {
  EXPECT_FALSE(registration.ok);
  EXPECT_FALSE(registration.reason.empty());
  ASSERT_EQ(registration.views.size(), num_views);
  for (const ViewRegistration& view : registration.views) {
    EXPECT_FALSE(view.ok);
    EXPECT_FALSE(view.reason.empty());
  }
  ExpectFinite(registration);
}

struct Case {
  const char* name;
  VoxelGrid grid;
  double size_m;
  std::vector<double> azimuths_rad;
  ViewSettings settings;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class RegisterShapeTruth : public testing::TestWithParam<Case> {};

TEST_P(RegisterShapeTruth, RecoversPoseAndScale) {
  const Case& c = GetParam();
  const FurnitureWorld world(c.grid, c.size_m);
  const std::vector<ObjectView> views = world.Views(c.azimuths_rad, c.settings);
  const CandidateRegistration result = RegisterCandidate(
      CandidateFor(0.5 * c.size_m, 1.7 * c.size_m), world.model(), views, RegisterOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_NEAR(result.scale_m / world.world_from_object().scale, 1.0, kScaleTolerance);
  EXPECT_THAT(result.world_from_object,
              PoseNear(world.world_from_object().RigidPart(), kPositionTolerance, kAngleTolerance));
  int num_ok = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!result.views[i].ok) continue;
    ++num_ok;
    const Pose3 truth = world.WorldFromCamera(c.azimuths_rad[i], c.settings).Inverse() *
                        world.world_from_object().RigidPart();
    EXPECT_THAT(result.views[i].camera_from_object,
                PoseNear(truth, kPositionTolerance, kAngleTolerance));
  }
  EXPECT_GE(2 * num_ok, static_cast<int>(views.size()));
  ExpectFinite(result);
}

ViewSettings With(double occluded_share, double drift_m, double mask_error_px, double noise = 1) {
  ViewSettings settings;
  settings.occluded_share = occluded_share;
  settings.drift_m = drift_m;
  settings.mask_error_px = mask_error_px;
  settings.noise_factor = noise;
  return settings;
}

INSTANTIATE_TEST_SUITE_P(
    Worlds,
    RegisterShapeTruth,
    testing::Values(
        Case{"AllRound", testing_support::ChairGrid(), 0.9, Around(12, 0, 5.5), {}},
        Case{"OneView", testing_support::ChairGrid(), 0.9, {0.4}, {}},
        Case{"HalfOccluded", testing_support::ChairGrid(), 0.9, Around(6, 0, 1.5), With(0.5, 0, 0)},
        Case{"Drift2cm", testing_support::ChairGrid(), 0.9, Around(12, 0, 5.5), With(0, 0.02, 0)},
        Case{"HalfOccludedWithDrift",
             testing_support::ChairGrid(),
             1.0,
             Around(12, 0, 3.1),
             With(0.5, 0.02, 0)},
        Case{"WrongMasks", testing_support::ChairGrid(), 0.9, Around(12, 0, 5.5), With(0, 0, 4)},
        Case{"ThreefoldNoise",
             testing_support::ChairGrid(),
             0.9,
             Around(8, 0, 3.1),
             With(0, 0.01, 0, 3)}),
    [](const auto& test) { return test.param.name; });

TEST(RegisterShape, KeepsTheScaleWithinTheCandidatesBounds) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  const std::vector<ObjectView> views = world.Views(Around(6, 0, 3));
  const CandidateRegistration result =
      RegisterCandidate(CandidateFor(1.1, 1.3), world.model(), views, RegisterOptions());
  EXPECT_GE(result.scale_m, 1.1 / kModelExtent - 1e-9);
  EXPECT_LE(result.scale_m, 1.3 / kModelExtent + 1e-9);
}

TEST(RegisterShape, FindsTheChairWithoutAKnownGround) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  std::vector<ObjectView> views = world.Views(Around(8, 0, 4));
  for (ObjectView& view : views) view.ground_camera.reset();
  const CandidateRegistration result =
      RegisterCandidate(CandidateFor(0.5, 1.4), world.model(), views, RegisterOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_THAT(result.world_from_object,
              PoseNear(world.world_from_object().RigidPart(), kPositionTolerance, kAngleTolerance));
}

// A fused shape holds only what was seen: the chair's back above a table must not be pulled to the
// floor.
TEST(RegisterShape, AFusedPartNeedNotStandOnTheGround) {
  VoxelGrid back;
  testing_support::FillBox(back, {-0.1, -0.48, -0.3}, {0.1, 0.48, 0.3});
  FurnitureWorld world(back, 0.6);
  ShapeCandidate candidate = CandidateFor(0.4, 0.8, 0.6);
  std::vector<ObjectView> views = world.Views(Around(5, 0, 2));
  for (ObjectView& view : views) view.ground_camera->d_m += 0.6;  // the floor lies deeper
  candidate.source = CandidateSource::kFused;
  const CandidateRegistration result = RegisterCandidate(candidate, world.model(), views, {});
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_NEAR(result.world_from_object.translation_m.z(),
              world.world_from_object().translation_m.z(),
              kPositionTolerance);
}

TEST(RegisterShape, RefusesTheOneViewThatShowsAnotherPlace) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  std::vector<ObjectView> views = world.Views(Around(7, 0, 4));
  views[3].world_from_camera.translation_m += Eigen::Vector3d(0.8, 0.5, 0);
  const CandidateRegistration result =
      RegisterCandidate(CandidateFor(0.5, 1.4), world.model(), views, RegisterOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_THAT(result.world_from_object,
              PoseNear(world.world_from_object().RigidPart(), kPositionTolerance, kAngleTolerance));
  EXPECT_FALSE(result.views[3].ok);
  EXPECT_FALSE(result.views[3].reason.empty());
}

// Behind a table only the chair's back is seen, and its two faces explain the depth alike: the one
// that faces the cameras is taken. Seen whole from behind, the chair keeps its true front.
TEST(RegisterShape, TakesTheBackAboveATableForAChairThatFacesUs) {
  const double yaw_rad = 0.7;
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9, yaw_rad);
  const auto cosine_to_truth = [&](double from_rad, double occluded_share) {
    const std::vector<ObjectView> views =
        world.Views(Around(5, from_rad - 0.4, from_rad + 0.4), With(occluded_share, 0, 0));
    const CandidateRegistration result =
        RegisterCandidate(CandidateFor(0.8, 1.0), world.model(), views, RegisterOptions());
    EXPECT_TRUE(result.ok) << result.reason;
    return (result.world_from_object.rotation * Eigen::Vector3d::UnitX())
        .dot(world.world_from_object().rotation * Eigen::Vector3d::UnitX());
  };
  EXPECT_GT(cosine_to_truth(yaw_rad, 0.6), 0.9);
  EXPECT_GT(cosine_to_truth(yaw_rad + std::numbers::pi, 0.0), 0.9);
}

// A block is alike from all sides, so that the search turns its front to the cameras.
TEST(RegisterShape, AShapeStaysAsItsSourceMeasuredIt) {
  const double yaw_rad = 0.7;
  const FurnitureWorld world(testing_support::BlockGrid(), 0.9, yaw_rad);
  const double behind_rad = yaw_rad + std::numbers::pi;
  const std::vector<ObjectView> views =
      world.Views(Around(5, behind_rad - 0.4, behind_rad + 0.4), With(0.3, 0, 0));
  ShapeCandidate candidate = CandidateFor(0.8, 1.0, 0.9);
  candidate.source = CandidateSource::kFused;
  const auto cosine_to_truth = [&](const CandidateRegistration& result) {
    EXPECT_TRUE(result.ok) << result.reason;
    return (result.world_from_object.rotation * Eigen::Vector3d::UnitX())
        .dot(world.world_from_object().rotation * Eigen::Vector3d::UnitX());
  };
  EXPECT_LT(cosine_to_truth(RegisterCandidate(candidate, world.model(), views, {})), 0.3);
  candidate.world_from_object = world.world_from_object();
  candidate.world_from_object->translation_m += Eigen::Vector3d(0.03, -0.02, 0.01);
  const CandidateRegistration result = RegisterCandidate(candidate, world.model(), views, {});
  EXPECT_GT(cosine_to_truth(result), 0.98);
  EXPECT_THAT(result.world_from_object,
              PoseNear(world.world_from_object().RigidPart(), kPositionTolerance, kAngleTolerance));
}

// The same block, seen from its left alone: its back turns to the wall, wherever that stands.
TEST(RegisterShape, ABlockTurnsItsBackToTheWallItStandsAt) {
  const double yaw_rad = 0.7;
  const FurnitureWorld world(testing_support::BlockGrid(), 0.9, yaw_rad);
  const double left_rad = yaw_rad + 0.5 * std::numbers::pi;
  const std::vector<ObjectView> views = world.Views(Around(5, left_rad - 0.2, left_rad + 0.2));
  const auto front_along = [&](const Layout& layout, double azimuth_rad) {
    const CandidateRegistration result = RegisterCandidate(
        CandidateFor(0.8, 1.0, 0.9), world.model(), views, RegisterOptions(), &layout);
    EXPECT_TRUE(result.ok) << result.reason;
    return (result.world_from_object.rotation * Eigen::Vector3d::UnitX())
        .dot(Eigen::Vector3d(std::cos(azimuth_rad), std::sin(azimuth_rad), 0));
  };
  const Eigen::Vector2d middle_m = world.world_from_object().translation_m.head<2>();
  for (const double azimuth_rad : {yaw_rad, yaw_rad + std::numbers::pi}) {
    const Eigen::Vector2d front(std::cos(azimuth_rad), std::sin(azimuth_rad));
    const Eigen::Vector2d along(front.y(), -front.x());  // with the room on its left
    const Eigen::Vector2d foot_m =
        middle_m - (0.25 * world.world_from_object().scale + 0.03) * front;
    LayoutWall wall;
    wall.from_m = foot_m - 2 * along;
    wall.to_m = foot_m + 2 * along;
    wall.top_m = 2.5;
    Layout layout;
    layout.walls.push_back(wall);
    EXPECT_GT(front_along(layout, azimuth_rad), 0.95);
  }
}

TEST(RegisterShape, IsSearchedForWhereItsSourcesPlaceShowsNothingOfIt) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  const std::vector<ObjectView> views = world.Views(Around(6, 0, 3));
  ShapeCandidate candidate = CandidateFor(0.5, 1.4);
  candidate.world_from_object = world.world_from_object();
  candidate.world_from_object->translation_m.x() += 3;
  const CandidateRegistration result = RegisterCandidate(candidate, world.model(), views, {});
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_THAT(result.world_from_object,
              PoseNear(world.world_from_object().RigidPart(), kPositionTolerance, kAngleTolerance));
}

TEST(RegisterShape, TellsThatARoundTablesYawIsFree) {
  const FurnitureWorld round(testing_support::RoundTableGrid(), 1.2);
  const FurnitureWorld square(testing_support::TableGrid(), 1.2);
  const ShapeCandidate candidate = CandidateFor(0.6, 2);
  const auto views_of = [](const FurnitureWorld& world) { return world.Views(Around(4, 0, 2)); };
  for (const ViewRegistration& view :
       RegisterCandidate(candidate, round.model(), views_of(round), {}).views) {
    EXPECT_TRUE(view.ok && view.yaw_free) << view.reason;
    // Ten times weaker than what 15 degrees would be.
    EXPECT_LT(view.information(5, 5), 2.0);
  }
  for (const ViewRegistration& view :
       RegisterCandidate(candidate, square.model(), views_of(square), {}).views) {
    EXPECT_TRUE(view.ok && !view.yaw_free) << view.reason;
  }
}

TEST(RegisterShape, SameInputSameBytes) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  const std::vector<ObjectView> views = world.Views(Around(3, 0, 2));
  const ShapeCandidate candidate = CandidateFor(0.5, 1.4);
  const auto first = RegisterCandidate(candidate, world.model(), views, {});
  const auto second = RegisterCandidate(candidate, world.model(), views, {});
  EXPECT_EQ(first.scale_m, second.scale_m);
  EXPECT_EQ(first.world_from_object, second.world_from_object);
  EXPECT_EQ(first.views[1].information, second.views[1].information);
}

// A view whose mask keeps only the pixels that `keep(u, v)` allows.
template <typename Keep>
ObjectView Masked(ObjectView view, Keep keep) {
  for (int v = 0; v < view.mask_crop.height(); ++v) {
    for (int u = 0; u < view.mask_crop.width(); ++u) {
      if (!keep(u, v)) view.mask_crop(u, v) = 0;
    }
  }
  return view;
}

TEST(RegisterShape, RefusesWhatTellsNothing) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  const ObjectView view = world.View(0, 0.3, {});
  const ShapeCandidate candidate = CandidateFor(0.5, 1.4);
  const auto refuse = [&](const shape::ShapeModel& model, std::vector<ObjectView> views) {
    ExpectRefused(RegisterCandidate(candidate, model, views, {}), views.size());
  };
  refuse(world.model(), {});
  refuse(world.model(), {ObjectView()});
  refuse(shape::ShapeModel(VoxelGrid()), {view, view});
  refuse(shape::ShapeModel(testing_support::FullGrid()), {view, view});
  refuse(world.model(), {Masked(view, [](int, int) { return false; })});
  refuse(world.model(), {Masked(view, [](int u, int v) { return u == 80 && v == 90; })});
  refuse(world.model(), {Masked(view, [](int u, int v) { return u > 70 && u < 81 && v == 90; })});
  ObjectView not_a_number = view;
  for (float& depth : not_a_number.depth_crop_m) depth = std::numeric_limits<float>::quiet_NaN();
  refuse(world.model(), {not_a_number});
  ObjectView no_pose = view;
  no_pose.world_from_camera.translation_m.x() = std::numeric_limits<double>::infinity();
  refuse(world.model(), {no_pose});
  ObjectView mismatched = view;
  mismatched.mask_crop = Mask(3, 3, 1);
  refuse(world.model(), {mismatched});
}

TEST(RegisterShape, StaysFiniteWhateverTheCandidateClaims) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  const std::vector<ObjectView> views = world.Views({0.3, 0.6});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const ShapeCandidate& candidate : {CandidateFor(nan, nan, nan),
                                          CandidateFor(-1, -2, -3),
                                          CandidateFor(2, 0.5, 9),
                                          CandidateFor(0.5, inf, inf),
                                          CandidateFor(0, 0)}) {
    ExpectFinite(RegisterCandidate(candidate, world.model(), views, {}));
  }
}

}  // namespace
}  // namespace deepslam::registration
