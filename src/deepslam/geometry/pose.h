// Rigid transforms. `b_from_a` maps points of frame a to frame b: x_b = b_from_a * x_a, names
// cancel along a product.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace deepslam {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// b_from_a: x_b = rotation * x_a + translation_m.
struct Pose3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // unit; on disk `rotation_xyzw`
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& x_a) const {
    return rotation * x_a + translation_m;
  }
  // c_from_b * b_from_a = c_from_a; the rotation is renormalised.
  [[nodiscard]] Pose3 operator*(const Pose3& b_from_a) const {
    return {(rotation * b_from_a.rotation).normalized(),
            rotation * b_from_a.translation_m + translation_m};
  }
  [[nodiscard]] Pose3 Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse, -(inverse * translation_m)};
  }
  [[nodiscard]] Eigen::Matrix4d Matrix() const;
  static Pose3 FromMatrix(const Eigen::Matrix4d& b_from_a);
  friend bool operator==(const Pose3& a, const Pose3& b) {
    return a.rotation.coeffs() == b.rotation.coeffs() && a.translation_m == b.translation_m;
  }
};

// Rotation vector (axis * angle, rad, angle in [0, pi]) of a unit quaternion, and back.
[[nodiscard]] Eigen::Vector3d RotationVector(const Eigen::Quaterniond& rotation);
[[nodiscard]] Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& rotation_vector_rad);

// t2v of the paper: (translation; rotation vector) of a transform. Not the SE(3) logarithm: the
// translation is the matrix's own. Information matrices of edges are in this order. v2t is its
// inverse.
[[nodiscard]] Vector6d T2v(const Pose3& b_from_a);
[[nodiscard]] Pose3 V2t(const Vector6d& translation_rotation);

// Angle of the rotation, rad, in [0, pi].
[[nodiscard]] double RotationAngle(const Eigen::Quaterniond& rotation);

// [v]x, so that [v]x w = v x w.
[[nodiscard]] Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v);

// The adjoint in (translation; rotation) order: a small left perturbation d of a_from_b in frame a
// equals the perturbation Adjoint(b_from_a) * d in frame b.
[[nodiscard]] Matrix6d Adjoint(const Pose3& b_from_a);

}  // namespace deepslam
