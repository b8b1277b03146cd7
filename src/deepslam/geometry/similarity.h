// Similarity transforms, for models of unit size. x_b = scale * (rotation * x_a) + translation_m.
#pragma once

#include "deepslam/geometry/pose.h"

namespace deepslam {

struct Similarity3 {
  double scale = 1.0;  // > 0; metres per model unit where a is an object frame and b a metric one
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  static Similarity3 From(const Pose3& b_from_a, double scale) {
    return {scale, b_from_a.rotation, b_from_a.translation_m};
  }
  // The rigid part: b_from_a with the scale taken off a (object frame in metres, same origin and
  // axes).
  [[nodiscard]] Pose3 RigidPart() const { return {rotation, translation_m}; }

  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& x_a) const {
    return scale * (rotation * x_a) + translation_m;
  }
  // c_from_b * b_from_a = c_from_a.
  [[nodiscard]] Similarity3 operator*(const Similarity3& b_from_a) const {
    return {scale * b_from_a.scale,
            (rotation * b_from_a.rotation).normalized(),
            scale * (rotation * b_from_a.translation_m) + translation_m};
  }
  [[nodiscard]] Similarity3 Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {1.0 / scale, inverse, -(inverse * translation_m) / scale};
  }
  friend bool operator==(const Similarity3& a, const Similarity3& b) {
    return a.scale == b.scale && a.rotation.coeffs() == b.rotation.coeffs() &&
           a.translation_m == b.translation_m;
  }
};

// c_from_b * b_from_a with a rigid outer transform.
[[nodiscard]] inline Similarity3 operator*(const Pose3& c_from_b, const Similarity3& b_from_a) {
  return Similarity3::From(c_from_b, 1.0) * b_from_a;
}

// The same by its matrix, for many points.
struct SimilarityMatrix {
  explicit SimilarityMatrix(const Similarity3& b_from_a)
      : rotation(b_from_a.rotation.toRotationMatrix()),
        linear(b_from_a.scale * rotation),
        translation_m(b_from_a.translation_m) {}
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& x_a) const {
    return linear * x_a + translation_m;
  }
  Eigen::Matrix3d rotation;
  Eigen::Matrix3d linear;  // scale * rotation
  Eigen::Vector3d translation_m;
};

}  // namespace deepslam
