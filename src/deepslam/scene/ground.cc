#include "deepslam/scene/ground.h"

#include <cmath>

namespace deepslam {

Eigen::Matrix<double, 3, 2> GroundTangentBasis(const Eigen::Vector3d& normal) {
  // The coordinate axis least aligned with the normal keeps the cross product well away from zero.
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Eigen::Vector3d b1 = normal.cross(Eigen::Vector3d::Unit(axis)).normalized();
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = b1;
  basis.col(1) = normal.cross(b1);
  return basis;
}

}  // namespace deepslam
