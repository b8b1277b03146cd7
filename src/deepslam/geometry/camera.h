// A pinhole camera without distortion. Camera axes: x right, y down, z forward. Pixel (0, 0) is a
// pixel centre.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace deepslam {

struct PinholeCamera {
  int width = 0;   // px
  int height = 0;  // px
  double fx = 0;   // px
  double fy = 0;   // px
  double cx = 0;   // px
  double cy = 0;   // px

  // Direction with z = 1 through pixel (u, v); times depth gives the point in the camera frame.
  [[nodiscard]] Eigen::Vector3d Ray(double u, double v) const {
    return {(u - cx) / fx, (v - cy) / fy, 1.0};
  }
  [[nodiscard]] Eigen::Vector3d Unproject(double u, double v, double depth_m) const {
    return depth_m * Ray(u, v);
  }
  // Pixel of a point with z > 0, also outside the image; nothing for a point at or behind the
  // camera.
  [[nodiscard]] std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_camera) const {
    if (p_camera.z() <= 1e-6) return std::nullopt;
    return Eigen::Vector2d(fx * p_camera.x() / p_camera.z() + cx,
                           fy * p_camera.y() / p_camera.z() + cy);
  }
  // The camera of the same view with images 1/factor as wide and high, pixels being means of factor
  // x factor blocks.
  [[nodiscard]] PinholeCamera Reduced(int factor) const {
    const double f = factor;
    return {width / factor,
            height / factor,
            fx / f,
            fy / f,
            (cx + 0.5) / f - 0.5,
            (cy + 0.5) / f - 0.5};
  }
  friend bool operator==(const PinholeCamera&, const PinholeCamera&) = default;
};

}  // namespace deepslam
