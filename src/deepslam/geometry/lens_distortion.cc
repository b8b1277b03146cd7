#include "deepslam/geometry/lens_distortion.h"

#include <cmath>

namespace deepslam {
namespace {

// tan of 85 degrees, beyond any pinhole picture, and the steps in which it is looked through.
constexpr double kFarthestRadius = 11.4;
// Tangent of the angle: turning points are found to a few pixels.
constexpr double kRadiusStep = 0.005;

// How far from the middle the lens shows what a pinhole shows at r, over r.
double RadialScale(const LensDistortion& lens, double r_squared) {
  const std::array<double, 8>& k = lens.coefficients;
  if (lens.model == LensModel::kFisheye) {
    const double r = std::sqrt(r_squared);
    if (r < 1e-8) return 1;
    const double a = std::atan(r);
    const double a2 = a * a;
    return a * (1 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))) / r;
  }
  const double above = 1 + r_squared * (k[0] + r_squared * (k[1] + r_squared * k[4]));
  if (lens.model == LensModel::kRadialTangential) return above;
  return above / (1 + r_squared * (k[5] + r_squared * (k[6] + r_squared * k[7])));
}

}  // namespace

int LensDistortion::NumCoefficients(LensModel model) {
  switch (model) {
    case LensModel::kRadialTangential:
      return 5;
    case LensModel::kRational:
      return 8;
    case LensModel::kFisheye:
      return 4;
  }
  return 0;
}

Eigen::Vector2d LensDistortion::Distort(const Eigen::Vector2d& pinhole) const {
  const double r_squared = pinhole.squaredNorm();
  const Eigen::Vector2d radial = RadialScale(*this, r_squared) * pinhole;
  if (model == LensModel::kFisheye) return radial;
  const double p1 = coefficients[2], p2 = coefficients[3];
  const double x = pinhole.x(), y = pinhole.y();
  return radial + Eigen::Vector2d(2 * p1 * x * y + p2 * (r_squared + 2 * x * x),
                                  p1 * (r_squared + 2 * y * y) + 2 * p2 * x * y);
}

double LensDistortion::LargestRadius() const {
  double before = 0;
  for (double r = kRadiusStep; r < kFarthestRadius; r += kRadiusStep) {
    const double shown = r * RadialScale(*this, r * r);
    if (!(shown > before)) return r - kRadiusStep;
    before = shown;
  }
  return kFarthestRadius;
}

}  // namespace deepslam
