#include "deepslam/graph/information.h"

#include <cmath>

namespace deepslam::graph {

YawFreeMeasurement WithoutYaw(const Pose3& a_from_b,
                              const Matrix6d& information,
                              const Pose3& a_from_b_expected) {
  const Eigen::Quaterniond difference = a_from_b.rotation.conjugate() * a_from_b_expected.rotation;
  // The part of the difference that turns about z (swing-twist decomposition).
  const double yaw_rad = 2.0 * std::atan2(difference.z(), difference.w());
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));

  Matrix6d turn_both = Matrix6d::Zero();
  turn_both.topLeftCorner<3, 3>() = turn.toRotationMatrix();
  turn_both.bottomRightCorner<3, 3>() = turn.toRotationMatrix();
  Matrix6d turned = turn_both.transpose() * information * turn_both;

  constexpr int kYaw = 5;  // the turn about z, last in t2v's order
  const Vector6d column = turned.col(kYaw);
  if (column[kYaw] > 0) turned -= column * column.transpose() / column[kYaw];
  turned.row(kYaw).setZero();
  turned.col(kYaw).setZero();
  return {{(a_from_b.rotation * turn).normalized(), a_from_b.translation_m}, turned};
}

}  // namespace deepslam::graph
