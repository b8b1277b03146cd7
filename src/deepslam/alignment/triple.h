// Vectors and rotations of which the compiler keeps one number each in a vector's lanes.
#pragma once

#include <Eigen/Core>

namespace deepslam::alignment {

struct Triple {
  float x = 0, y = 0, z = 0;
};

struct Rotation {
  explicit Rotation(const Eigen::Matrix3f& m)
      : r00(m(0, 0)),
        r01(m(0, 1)),
        r02(m(0, 2)),
        r10(m(1, 0)),
        r11(m(1, 1)),
        r12(m(1, 2)),
        r20(m(2, 0)),
        r21(m(2, 1)),
        r22(m(2, 2)) {}
  Triple operator*(const Triple& p) const {
    return {r00 * p.x + r01 * p.y + r02 * p.z,
            r10 * p.x + r11 * p.y + r12 * p.z,
            r20 * p.x + r21 * p.y + r22 * p.z};
  }
  float r00, r01, r02, r10, r11, r12, r20, r21, r22;
};

}  // namespace deepslam::alignment
