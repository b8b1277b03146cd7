// Axial noise of consumer depth cameras (Nguyen et al. 2012, Kinect).
#pragma once

#include <algorithm>
#include <cmath>

namespace deepslam {

// One standard deviation of a reading along the camera's axis:
// sigma(z) = base_m + growth_per_m * (z - 0.4)^2.
struct DepthNoise {
  double base_m = 0.0012;
  double growth_per_m = 0.0019;

  template <typename Real>
  [[nodiscard]] constexpr Real SigmaM(Real depth_m) const {
    const Real beyond_m = depth_m - static_cast<Real>(0.4);
    return static_cast<Real>(base_m) + static_cast<Real>(growth_per_m) * beyond_m * beyond_m;
  }

  [[nodiscard]] DepthNoise Scaled(double scale) const {
    return {scale * base_m, scale * growth_per_m};
  }

  // The depth to which readings are this good; 0.4 m where none are.
  [[nodiscard]] double ReachM(double sigma_m) const {
    return 0.4 + std::sqrt(std::max(0.0, sigma_m - base_m) / growth_per_m);
  }
};

template <typename Real>
[[nodiscard]] constexpr Real DepthSigmaM(Real depth_m) {
  return DepthNoise{}.SigmaM(depth_m);
}

}  // namespace deepslam
