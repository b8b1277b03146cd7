// What a lens does to a pinhole's picture, by OpenCV's models.
//
// Coordinates are those of the image plane at z = 1: (x, y) of a pinhole becomes the (x, y) at
// which the lens shows the same point; the same focal lengths and principal point make pixels of
// both.
//   radial-tangential, rational, r^2 = x^2 + y^2:
//     (x, y) (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
//       + (2 p1 x y + p2 (r^2 + 2 x^2), p1 (r^2 + 2 y^2) + 2 p2 x y)
//   fisheye (Kannala and Brandt 2006), a = atan(r):
//     (x, y) a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8) / r
#pragma once

#include <array>

#include <Eigen/Core>

namespace deepslam {

enum class LensModel { kRadialTangential, kRational, kFisheye };

struct LensDistortion {
  LensModel model = LensModel::kRadialTangential;
  // In OpenCV's order: k1 k2 p1 p2 k3 (radial-tangential), and k4 k5 k6 behind them (rational), or
  // k1 k2 k3 k4 (fisheye).
  std::array<double, 8> coefficients{};

  // How many of the coefficients a model has.
  [[nodiscard]] static int NumCoefficients(LensModel model);
  // No lens at all.
  [[nodiscard]] bool IsNone() const { return *this == LensDistortion{model, {}}; }

  // Where the lens shows what a pinhole shows at `pinhole`.
  [[nodiscard]] Eigen::Vector2d Distort(const Eigen::Vector2d& pinhole) const;
  // From the middle, in the pinhole's plane, up to where the model is one to one: beyond it turns
  // back on itself, and a place of the picture would stand for several directions.
  [[nodiscard]] double LargestRadius() const;

  friend bool operator==(const LensDistortion&, const LensDistortion&) = default;
};

}  // namespace deepslam
