#include "deepslam/loop/corner_loop.h"

#include <Eigen/LU>

#include "deepslam/core/angles.h"
#include "deepslam/loop/registered_pair.h"

namespace deepslam::loop {
namespace {}  // namespace

bool BearsOut(const FeaturePose& pose) {
  return pose.num_rivals <= AppearanceOptions::kAmbiguityRatio * pose.num_inliers &&
         pose.spread_rad >= kRadPerDeg * AppearanceOptions::kMinSpread_deg;
}

std::string Verdict(const AppearanceLoop& loop, const KeyframeRegistration& registration) {
  return Verdict(registration,
                 loop.old_from_new,
                 {AppearanceOptions::kMinAgreement,
                  AppearanceOptions::kMinCorrelation,
                  AppearanceOptions::kMaxMove_m,
                  AppearanceOptions::kMaxTurn_deg});
}

Matrix6d EdgeInformation(const Matrix6d& information,
                         double variance_scale,
                         double floor_m,
                         double floor_rad) {
  Vector6d floor;
  floor << Eigen::Vector3d::Constant(floor_m), Eigen::Vector3d::Constant(floor_rad);
  Matrix6d covariance = variance_scale * information.inverse();
  covariance.diagonal() += floor.cwiseAbs2();
  const Matrix6d result = covariance.inverse();
  return 0.5 * (result + result.transpose());
}

}  // namespace deepslam::loop
