#include "deepslam/geometry/pose.h"

#include <cmath>

namespace deepslam {

Eigen::Matrix4d Pose3::Matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = translation_m;
  return matrix;
}

Pose3 Pose3::FromMatrix(const Eigen::Matrix4d& b_from_a) {
  const Eigen::Matrix3d rotation = b_from_a.topLeftCorner<3, 3>();
  return {Eigen::Quaterniond(rotation).normalized(), b_from_a.topRightCorner<3, 1>()};
}

Eigen::Vector3d RotationVector(const Eigen::Quaterniond& rotation) {
  // q and -q are one rotation; the one with w >= 0 turns by at most pi.
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  const Eigen::Vector3d vec = sign * rotation.vec();
  const double sine = vec.norm();
  if (sine < 1e-12) return 2.0 * vec;
  return (2.0 * std::atan2(sine, sign * rotation.w()) / sine) * vec;
}

Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& rotation_vector_rad) {
  const double angle = rotation_vector_rad.norm();
  const double half = 0.5 * angle;
  const double scale = angle < 1e-12 ? 0.5 : std::sin(half) / angle;
  Eigen::Quaterniond rotation;
  rotation.w() = std::cos(half);
  rotation.vec() = scale * rotation_vector_rad;
  return rotation.normalized();
}

Vector6d T2v(const Pose3& b_from_a) {
  Vector6d v;
  v << b_from_a.translation_m, RotationVector(b_from_a.rotation);
  return v;
}

Pose3 V2t(const Vector6d& translation_rotation) {
  return {RotationFromVector(translation_rotation.tail<3>()), translation_rotation.head<3>()};
}

double RotationAngle(const Eigen::Quaterniond& rotation) {
  return 2.0 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
}

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Matrix6d Adjoint(const Pose3& b_from_a) {
  const Eigen::Matrix3d rotation = b_from_a.rotation.toRotationMatrix();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = rotation;
  adjoint.bottomRightCorner<3, 3>() = rotation;
  adjoint.topRightCorner<3, 3>() = CrossMatrix(b_from_a.translation_m) * rotation;
  return adjoint;
}

}  // namespace deepslam
