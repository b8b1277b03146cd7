#include "deepslam/tracking/motion_gate.h"

#include <algorithm>
#include <cmath>

namespace deepslam::tracking {
namespace {

using alignment::kPredictionSigma;
using alignment::StartSigma;

// A motion is carried on over at most this many times the interval it was measured in.
constexpr double kMaxPredictionRatio = 3.0;
// Of cameras in hands, one standard deviation.
constexpr double kHandSpeed = 0.5;        // m/s
constexpr double kHandAcceleration = 2;   // m/s^2
constexpr double kWristSpeed = 0.7;       // rad/s
constexpr double kWristAcceleration = 4;  // rad/s^2
constexpr double kManySigmas = 5;         // farther off, it was not a hand
// Farther off, or after a longer time, a prediction is none.
constexpr StartSigma kFarthestPrediction;

}  // namespace

void MotionModel::Observe(const Pose3& before_from_after, double interval_s, bool unobserved) {
  before_from_after_ = before_from_after;
  interval_s_ = interval_s;
  unobserved_s_ = unobserved ? unobserved_s_ + interval_s : 0;
}

std::optional<Pose3> MotionModel::Predict(double duration_s) const {
  if (!(interval_s_ > 0)) return std::nullopt;
  const double ratio = duration_s / interval_s_;
  if (!(ratio > 0) || ratio > kMaxPredictionRatio) return std::nullopt;
  return V2t(ratio * T2v(before_from_after_));
}

StartSigma MotionModel::SigmaOfStart(double duration_s) const {
  StartSigma sigma;
  if (!(duration_s > 0) || !(interval_s_ > 0)) return sigma;
  const double motion_age_s = 0.5 * interval_s_ + unobserved_s_;
  const double speed_error_m_per_s = predicts_ ? kHandAcceleration * motion_age_s : kHandSpeed;
  const double turn_error_per_s = predicts_ ? kWristAcceleration * motion_age_s : kWristSpeed;
  const double reach_m = std::max(sigma.translation_m, kHandSpeed * duration_s);
  const double turned_rad = std::max(sigma.rotation_rad, kWristSpeed * duration_s);
  sigma.translation_m = std::min(reach_m, speed_error_m_per_s * duration_s);
  sigma.rotation_rad = std::min(turned_rad, turn_error_per_s * duration_s);
  return sigma;
}

MotionLikelihood LikelihoodOf(const Pose3& world_from_camera, const ExpectedMotion& motion) {
  const Pose3 expected = motion.world_from_predicted.value_or(motion.world_from_last);
  const Pose3 off = expected.Inverse() * world_from_camera;
  const double off_m = off.translation_m.norm();
  const double off_rad = RotationAngle(off.rotation);
  if (motion.world_from_predicted) {
    const double sigma_m = std::hypot(motion.sigma.translation_m, kPredictionSigma.translation_m);
    const double sigma_rad = std::hypot(motion.sigma.rotation_rad, kPredictionSigma.rotation_rad);
    if (off_m <= std::min(kFarthestPrediction.translation_m, kManySigmas * sigma_m) &&
        off_rad <= std::min(kFarthestPrediction.rotation_rad, kManySigmas * sigma_rad))
      return MotionLikelihood::kAsPredicted;
  }
  // Back the way it came is twice the motion off.
  const Pose3 carried = motion.world_from_last.Inverse() * expected;
  const bool of_a_hand =
      off_m <= kManySigmas * kHandSpeed * motion.duration_s + 2 * carried.translation_m.norm() &&
      off_rad <=
          kManySigmas * kWristSpeed * motion.duration_s + 2 * RotationAngle(carried.rotation);
  return of_a_hand || !(motion.duration_s > 0) ? MotionLikelihood::kOfAHand
                                               : MotionLikelihood::kUnlikely;
}

}  // namespace deepslam::tracking
