// The residuals of the graph, whitened; generic in the scalar so that Ceres differentiates them
// automatically.
//
// A pose block is world_from_x as (qx, qy, qz, qw, tx, ty, tz); the plane block is (nx, ny, nz, d).
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/geometry/pose.h"

namespace deepslam::graph {

// Rotation vector of a unit quaternion, differentiable at the identity.
template <typename T>
Eigen::Matrix<T, 3, 1> RotationVectorOf(const Eigen::Quaternion<T>& q) {
  using std::atan2;
  using std::sqrt;
  const T sign = q.w() < T(0) ? T(-1) : T(1);
  const Eigen::Matrix<T, 3, 1> vec = sign * q.vec();
  const T squared = vec.squaredNorm();
  // Below, 2 atan2(|v|, w) / |v| = 2 to double precision, and sqrt has no derivative at 0.
  if (squared < T(1e-18)) return T(2) * vec;
  const T sine = sqrt(squared);
  return (T(2) * atan2(sine, sign * q.w()) / sine) * vec;
}

// r = L t2v(z_ab^-1 x_wa^-1 x_wb), L^T L = information: r_io and r_ij of the paper. 6 values, in
// frame b.
struct PoseResidual {
  Pose3 b_from_a_measured;  // z_ab^-1
  Matrix6d sqrt_information;

  template <typename T>
  bool operator()(const T* world_from_a, const T* world_from_b, T* residual) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q_a(world_from_a), q_b(world_from_b);
    const Eigen::Map<const Vec3> t_a(world_from_a + 4), t_b(world_from_b + 4);
    const Eigen::Quaternion<T> a_from_world = q_a.conjugate();
    const Vec3 b_in_a = a_from_world * (t_b - t_a);
    const Eigen::Quaternion<T> q_z = b_from_a_measured.rotation.cast<T>();
    Eigen::Matrix<T, 6, 1> r;
    r.template head<3>() = q_z * b_in_a + b_from_a_measured.translation_m.cast<T>();
    r.template tail<3>() = RotationVectorOf<T>(q_z * (a_from_world * q_b));
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(residual);
    out = sqrt_information.cast<T>() * r;
    return true;
  }
};

// r_pi = p - p_w with p_w = [R n_i; d_i - (R n_i)^T t] (paper), weighted by the information of the
// measurement's three degrees of freedom. 3 values.
//
// The measurement's small errors (a in R^2 along the tangent basis B of n_i, s of d_i) move the
// world's 4-vector by
//   J (a, s),   J = [ R B          0 ]
//                   [ -t^T R B     1 ]     (from d_w = d - (R n)^T t),
// so a frame far from the origin turns a small rotation into a large change of d_w: n and d are
// strongly coupled in the world. J has rank 3; the 4-vector's three observable directions are found
// by the left inverse (K J = I)
//   K = [ (R B)^T   0 ]
//       [ t^T       1 ],
// and Omega_w = K^T Omega_i K is the measurement's information carried to the world. K r_pi is what
// is whitened here:
//   (R B)^T (n - R n_i) = B^T R^T n
//     the world's normal seen along the measured tangent directions;
//   t^T (n - R n_i) + d - d_w = n^T t + d - d_i
//     the camera's height above the world's plane minus the measured one.
// Other left inverses differ by second order in the tilt times the distance to the origin; this one
// does not depend on where the origin is, which is why it was chosen.
struct GroundResidual {
  Eigen::Matrix<double, 3, 2> tangent_basis;  // of n_i
  double d_m = 0;                             // d_i
  Eigen::Matrix3d sqrt_information;

  template <typename T>
  bool operator()(const T* world_from_camera, const T* plane, T* residual) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q(world_from_camera);
    const Eigen::Map<const Vec3> t(world_from_camera + 4), n(plane);
    const Vec3 n_camera = q.conjugate() * n;
    Vec3 r;
    r.template head<2>() = tangent_basis.transpose().cast<T>() * n_camera;
    r[2] = n.dot(t) + plane[3] - T(d_m);
    Eigen::Map<Vec3> out(residual);
    out = sqrt_information.cast<T>() * r;
    return true;
  }
};

// r_po = n - R (0, 0, 1)^T (paper). 3 values, world, without unit.
struct UprightResidual {
  template <typename T>
  bool operator()(const T* world_from_object, const T* plane, T* residual) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q(world_from_object);
    const Eigen::Map<const Vec3> n(plane);
    Eigen::Map<Vec3> out(residual);
    out = n - q * Vec3(T(0), T(0), T(1));
    return true;
  }
};

}  // namespace deepslam::graph
