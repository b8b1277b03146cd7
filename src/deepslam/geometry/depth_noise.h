// Axial noise of consumer depth cameras (Nguyen et al. 2012, Kinect).
#pragma once

namespace deepslam {

// Standard deviation of a reading along the camera's axis, metres.
template <typename Real>
[[nodiscard]] constexpr Real DepthSigmaM(Real depth_m) {
  const Real beyond_m = depth_m - static_cast<Real>(0.4);
  return static_cast<Real>(0.0012) + static_cast<Real>(0.0019) * beyond_m * beyond_m;
}

}  // namespace deepslam
