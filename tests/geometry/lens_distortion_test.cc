#include "deepslam/geometry/lens_distortion.h"

#include <cmath>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

TEST(LensDistortion, IsOpenCvsRadialTangentialModel) {
  // Written out by hand at (0.3, -0.2): r^2 = 0.13.
  const LensDistortion lens{LensModel::kRadialTangential, {-0.3, 0.1, 0.01, -0.02, 0.05}};
  const double x = 0.3, y = -0.2, r2 = 0.13;
  const double radial = 1 - 0.3 * r2 + 0.1 * r2 * r2 + 0.05 * r2 * r2 * r2;
  const Eigen::Vector2d shown = lens.Distort({x, y});
  EXPECT_NEAR(shown.x(), x * radial + 2 * 0.01 * x * y - 0.02 * (r2 + 2 * x * x), 1e-12);
  EXPECT_NEAR(shown.y(), y * radial + 0.01 * (r2 + 2 * y * y) - 2 * 0.02 * x * y, 1e-12);
}

TEST(LensDistortion, RationalWithoutDenominatorIsRadialTangential) {
  const LensDistortion plain{LensModel::kRadialTangential, {-0.2, 0.05, 0.001, 0.002, 0.01}};
  LensDistortion rational = plain;
  rational.model = LensModel::kRational;
  EXPECT_EQ(rational.Distort({0.4, 0.1}), plain.Distort({0.4, 0.1}));
  rational.coefficients[5] = 0.5;
  EXPECT_LT(rational.Distort({0.4, 0}).x(), plain.Distort({0.4, 0}).x());
}

TEST(LensDistortion, FisheyeWithoutCoefficientsShowsAngles) {
  const LensDistortion lens{LensModel::kFisheye, {}};
  EXPECT_NEAR(lens.Distort({1, 0}).x(), std::atan(1.0), 1e-12);
  EXPECT_NEAR(lens.Distort({3, 4}).norm(), std::atan(5.0), 1e-12);
  EXPECT_EQ(lens.Distort({0, 0}), Eigen::Vector2d(0, 0));
}

TEST(LensDistortion, LargestRadiusIsWhereTheModelTurnsBack) {
  // r (1 - 0.3 r^2) grows up to r = 1 / sqrt(0.9).
  const LensDistortion barrel{LensModel::kRadialTangential, {-0.3}};
  EXPECT_NEAR(barrel.LargestRadius(), 1 / std::sqrt(0.9), 0.01);
  EXPECT_GT((LensDistortion{LensModel::kRadialTangential, {0.1}}).LargestRadius(), 10);
  EXPECT_GT((LensDistortion{LensModel::kFisheye, {}}).LargestRadius(), 10);
}

TEST(LensDistortion, OfBadCoefficientsNothingIsShown) {
  EXPECT_LT((LensDistortion{LensModel::kRadialTangential, {-1e9}}).LargestRadius(), 0.01);
  EXPECT_LT((LensDistortion{LensModel::kRational, {0, 0, 0, 0, 0, std::nan("")}}).LargestRadius(),
            0.01);
}

}  // namespace
}  // namespace deepslam
