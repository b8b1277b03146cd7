#include "deepslam/geometry/plane.h"

namespace deepslam {

// Not inline: Eigen's singular value decomposition behind it takes seconds in every file that sees
// it.
Eigen::Quaterniond ShortestRotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

}  // namespace deepslam
