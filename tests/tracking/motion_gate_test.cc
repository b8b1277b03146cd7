#include "deepslam/tracking/motion_gate.h"

#include <cmath>

#include <gtest/gtest.h>

#include "support/pose_matchers.h"

namespace deepslam::tracking {
namespace {

using alignment::StartSigma;
using testing_support::PoseNear;

constexpr double kInterval_s = 0.05;

Pose3 Moved(double x_m, double turn_rad = 0) {
  return V2t((Vector6d() << x_m, 0, 0, 0, turn_rad, 0).finished());
}

MotionModel Moving(const Pose3& motion, bool predicts = true) {
  MotionModel model(predicts);
  model.Observe(motion, kInterval_s, false);
  return model;
}

TEST(MotionModel, CarriesAMotionOnInProportionToTime) {
  for (const Pose3& motion : {Moved(0.03), Moved(0, 0.1)}) {
    const auto twice = Moving(motion).Predict(2 * kInterval_s);
    ASSERT_TRUE(twice.has_value());
    EXPECT_THAT(*twice, PoseNear(motion * motion, 1e-9, 1e-6));
  }
}

TEST(MotionModel, KnowsNothingAtFirstAcrossALossOrForLong) {
  EXPECT_FALSE(MotionModel(true).Predict(kInterval_s).has_value());
  MotionModel model = Moving(Moved(0.03));
  EXPECT_FALSE(model.Predict(0).has_value());
  EXPECT_FALSE(model.Predict(-kInterval_s).has_value());
  EXPECT_TRUE(model.Predict(2.9 * kInterval_s).has_value());
  EXPECT_FALSE(model.Predict(3.1 * kInterval_s).has_value());
  model.Forget();
  EXPECT_FALSE(model.Predict(kInterval_s).has_value());
}

TEST(MotionModel, AStartIsKnownTheWorseTheLongerAgoAndTheLongerNothingShowedItsMotion) {
  MotionModel model = Moving(Moved(0.03));
  const StartSigma soon = model.SigmaOfStart(kInterval_s);
  const StartSigma later = model.SigmaOfStart(4 * kInterval_s);
  EXPECT_LT(soon.translation_m, later.translation_m);
  EXPECT_LT(soon.rotation_rad, later.rotation_rad);
  model.Observe(Moved(0.03), kInterval_s, true);
  const StartSigma unobserved = model.SigmaOfStart(kInterval_s);
  EXPECT_GT(unobserved.translation_m, soon.translation_m);
  EXPECT_GT(unobserved.rotation_rad, soon.rotation_rad);
  model.Observe(Moved(0.03), kInterval_s, false);
  EXPECT_EQ(model.SigmaOfStart(kInterval_s).translation_m, soon.translation_m);
}

// A prediction is better than none over a frame or two, and never worse than a hand is fast.
TEST(MotionModel, AStartIsKnownToWithinWhatAHandDoes) {
  const double duration_s = 1.0;
  MotionModel model = Moving(Moved(0.03));
  for (int n = 0; n < 100; ++n) model.Observe(Moved(0.03), kInterval_s, true);
  EXPECT_LE(model.SigmaOfStart(duration_s).translation_m, 0.5 * duration_s + 1e-9);
  EXPECT_LE(model.SigmaOfStart(duration_s).rotation_rad, 0.7 * duration_s + 1e-9);
  EXPECT_LT(Moving(Moved(0.03), true).SigmaOfStart(kInterval_s).translation_m,
            Moving(Moved(0.03), false).SigmaOfStart(kInterval_s).translation_m);
  // What is not known at all is what alignments take it for.
  EXPECT_EQ(MotionModel(true).SigmaOfStart(kInterval_s).translation_m, StartSigma{}.translation_m);
}

ExpectedMotion Expected(const std::optional<Pose3>& predicted, double duration_s = kInterval_s) {
  ExpectedMotion expected;
  expected.world_from_predicted = predicted;
  expected.sigma = Moving(Moved(0.03)).SigmaOfStart(duration_s);
  expected.duration_s = duration_s;
  return expected;
}

TEST(LikelihoodOf, IsHighWhereTheCameraWasExpected) {
  const Pose3 predicted = Moved(0.03, 0.02);
  EXPECT_EQ(LikelihoodOf(predicted, Expected(predicted)), MotionLikelihood::kAsPredicted);
  EXPECT_EQ(LikelihoodOf(predicted * Moved(0.02, 0.01), Expected(predicted)),
            MotionLikelihood::kAsPredicted);
  // Without a prediction nothing is expected.
  EXPECT_EQ(LikelihoodOf(Pose3{}, Expected({})), MotionLikelihood::kOfAHand);
}

TEST(LikelihoodOf, NeverRisesFartherFromWhatWasExpected) {
  const Pose3 predicted = Moved(0.03);
  for (const bool is_turn : {false, true}) {
    MotionLikelihood before = MotionLikelihood::kAsPredicted;
    for (double off = 0; off < 1; off += 0.01) {
      const Pose3 place = predicted * (is_turn ? Moved(0, off) : Moved(off));
      const MotionLikelihood now = LikelihoodOf(place, Expected(predicted));
      EXPECT_GE(now, before) << off;
      before = now;
    }
    EXPECT_EQ(before, MotionLikelihood::kUnlikely);
  }
}

TEST(LikelihoodOf, AllowsAHandMoreInMoreTimeAndTheWayBack) {
  EXPECT_EQ(LikelihoodOf(Moved(0.4), Expected({}, kInterval_s)), MotionLikelihood::kUnlikely);
  EXPECT_EQ(LikelihoodOf(Moved(0.4), Expected({}, 1.0)), MotionLikelihood::kOfAHand);
  EXPECT_EQ(LikelihoodOf(Moved(0, 1.0), Expected({}, kInterval_s)), MotionLikelihood::kUnlikely);
  // A fast camera that turns round within a frame.
  EXPECT_EQ(LikelihoodOf(Moved(-0.3), Expected(Moved(0.3))), MotionLikelihood::kOfAHand);
}

// No clock, no gate.
TEST(LikelihoodOf, IsNeverUnlikelyWhereNoTimeIsKnownToHavePassed) {
  EXPECT_EQ(LikelihoodOf(Moved(3), Expected({}, 0)), MotionLikelihood::kOfAHand);
  EXPECT_EQ(LikelihoodOf(Moved(3), Expected({}, std::nan(""))), MotionLikelihood::kOfAHand);
}

}  // namespace
}  // namespace deepslam::tracking
