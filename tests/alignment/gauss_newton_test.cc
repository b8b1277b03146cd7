#include "deepslam/alignment/gauss_newton.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "deepslam/alignment/reference_pixels.h"
#include "support/pose_matchers.h"

namespace deepslam::alignment {
namespace {

using testing_support::BoxWorld;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::PoseNear;
using testing_support::RenderFrame;

constexpr double kFocalPx = 200;

TEST(ConvergenceEstimate, IsTheRestOfAGeometricSeries) {
  ConvergenceEstimate estimate;
  Vector6d step = Vector6d::Zero();
  step[0] = 0.04;
  (void)estimate.RemainingPx(step, kFocalPx);
  for (int n = 0; n < 5; ++n) {
    step *= 0.25;
    const double px = kFocalPx * step[0] / kConvergedDistanceM;
    EXPECT_NEAR(estimate.RemainingPx(step, kFocalPx), px * 0.25 / (1 - 0.25), 1e-9);
  }
}

TEST(ConvergenceEstimate, IsTheStepItselfWhereStepsDoNotShrinkOrAreNotKnown) {
  ConvergenceEstimate estimate;
  Vector6d step = Vector6d::Zero();
  step[4] = 0.01;
  for (int n = 0; n < 3; ++n)
    EXPECT_NEAR(estimate.RemainingPx(step, kFocalPx), kFocalPx * 0.01, 1e-9) << n;
}

// A fixed-point iteration whose error falls by the same share in each step.
TEST(AndersonMixing, EndsALinearIterationWithItsSecondMove) {
  for (const double share : {0.2, 0.5, 0.6}) {
    AndersonMixing mixing;
    Vector6d error = (Vector6d() << 0.03, 0, -0.02, 0.01, 0.005, 0).finished();
    for (int n = 0; n < 2; ++n) error -= mixing.Move((1 - share) * error);
    EXPECT_LT(error.norm(), 1e-9) << share;
  }
}

TEST(AndersonMixing, GoesNoFartherThanThreeStepsAtOnce) {
  AndersonMixing mixing;
  const Vector6d step = Vector6d::Unit(1);
  (void)mixing.Move(step);
  EXPECT_LE(mixing.Move(0.99 * step).norm(), 3.0);
  EXPECT_EQ(AndersonMixing().Move(step), step);
}

TEST(PixelsPerMeasurement, CountsSquaresOfTheLengthAtTheLevelsOwnSize) {
  PyramidLevel level;
  level.camera = {640, 480, 500, 500, 319.5, 239.5};
  EXPECT_NEAR(PixelsPerMeasurement(level, 1, 9), 81, 1e-9);
  EXPECT_NEAR(PixelsPerMeasurement(level, 3, 9), 9, 1e-9);
  level.camera.width = 320;
  EXPECT_NEAR(PixelsPerMeasurement(level, 1, 9), 81.0 / 4, 1e-9);
  EXPECT_EQ(PixelsPerMeasurement(level, 9, 9), 1) << "no pixel counts more than once";
}

TEST(LevelGates, HalveTheDistanceAtEachFinerLevel) {
  const AlignmentOptions options;
  EXPECT_FLOAT_EQ(LevelGates(options, 0).max_distance_m,
                  static_cast<float>(options.max_distance_m));
  EXPECT_FLOAT_EQ(LevelGates(options, 2).max_distance_m,
                  static_cast<float>(options.max_distance_m / 4));
}

TEST(IsAmong, TakesPlacesWithinMillimetresForOne) {
  const Pose3 place = V2t((Vector6d() << 1, 2, 3, 0.1, 0.2, 0.3).finished());
  const Pose3 beside = place * V2t((Vector6d() << 0.002, 0, 0, 0, 0.002, 0).finished());
  const Pose3 elsewhere = place * V2t((Vector6d() << 0.02, 0, 0, 0, 0, 0).finished());
  EXPECT_TRUE(IsSamePlace(place, beside));
  EXPECT_EQ(IsSamePlace(place, elsewhere), IsSamePlace(elsewhere, place));
  const std::array<Pose3, 2> places = {elsewhere, beside};
  EXPECT_TRUE(IsAmong(places, place));
  EXPECT_FALSE(IsAmong({places.data(), 1}, place));
  EXPECT_FALSE(IsAmong({}, place));
}

struct TwoFrames {
  FramePyramid i, j;
  Pose3 i_from_j;
};

TwoFrames Furnished() {
  const Pose3 world_from_i = LookAt({-1.6, -0.3, 1.4}, {0.5, 0.1, 0.5});
  const Pose3 i_from_j = V2t((Vector6d() << 0.03, -0.02, 0.02, 0.01, -0.02, 0.01).finished());
  const auto seen = [](const Pose3& world_from_camera, std::uint64_t seed) {
    return BuildPyramid(
        RenderFrame(BoxWorld::Furnished(), world_from_camera, 0.5, seed), kSmallCamera, {});
  };
  return {AsReference(seen(world_from_i, 1)), seen(world_from_i * i_from_j, 2), i_from_j};
}

TEST(Iterate, EndsAtTheTruthAndLeavesAWayToAKnownPlace) {
  const TwoFrames two = Furnished();
  const AlignmentOptions options;
  const SourcePoints points(two.j.levels.front(), {1, true, true});
  GaussNewtonState state = StartAt(Pose3{});
  EXPECT_TRUE(Iterate(two.i.levels.front(), points, options, state));
  EXPECT_THAT(state.i_from_j, PoseNear(two.i_from_j, 0.01, 0.3));
  EXPECT_GT(state.system.num_inliers, 0);
  const std::array<Pose3, 1> known = {state.i_from_j};
  GaussNewtonState again = StartAt(Pose3{});
  EXPECT_FALSE(Iterate(two.i.levels.front(), points, options, again, known));
}

TEST(Iterate, MakesNoStepsAlongFixedDirections) {
  const TwoFrames two = Furnished();
  const AlignmentOptions options;
  const SourcePoints points(two.j.levels.front(), {1, true, true});
  GaussNewtonState state = StartAt(Pose3{});
  // A Hessian that knows of nothing along x.
  Matrix6d hessian = Matrix6d::Identity();
  hessian(0, 0) = 0;
  state.fixed = DegenerateDirections(hessian);
  Iterate(two.i.levels.front(), points, options, state);
  // Small turns carry the centre of frame j along by less than a millimetre.
  EXPECT_LT(std::abs(state.i_from_j.translation_m.x()), 0.002);
}

}  // namespace
}  // namespace deepslam::alignment
