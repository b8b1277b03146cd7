#include "deepslam/convex/mass_properties.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace deepslam::convex {
namespace {

struct Corners {
  Eigen::Vector3d a, b, c;
};

Corners CornersOf(const TriangleMesh& mesh, std::size_t face) {
  const auto& f = mesh.faces[face];
  return {mesh.vertices[f[0]].cast<double>(),
          mesh.vertices[f[1]].cast<double>(),
          mesh.vertices[f[2]].cast<double>()};
}

}  // namespace

double VolumeOf(const TriangleMesh& closed) {
  double six_volumes = 0;
  for (std::size_t n = 0; n < closed.faces.size(); ++n) {
    const Corners t = CornersOf(closed, n);
    six_volumes += t.a.dot(t.b.cross(t.c));
  }
  return six_volumes / 6;
}

MassProperties MassPropertiesOf(const TriangleMesh& closed) {
  double six_volumes = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // integral of x x^T
  for (std::size_t n = 0; n < closed.faces.size(); ++n) {
    const Corners t = CornersOf(closed, n);
    const double det = t.a.dot(t.b.cross(t.c));  // of the tetrahedron to the origin
    const Eigen::Vector3d sum = t.a + t.b + t.c;
    six_volumes += det;
    first += det / 24 * sum;
    second += det / 120 *
              (t.a * t.a.transpose() + t.b * t.b.transpose() + t.c * t.c.transpose() +
               sum * sum.transpose());
  }
  MassProperties properties;
  properties.volume_m3 = six_volumes / 6;
  if (!(properties.volume_m3 > 0)) return {};
  properties.centre = first / properties.volume_m3;
  second -= properties.volume_m3 * properties.centre * properties.centre.transpose();
  const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  properties.inertia = solver.eigenvalues();
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  properties.mesh_from_axes = Eigen::Quaterniond(axes).normalized();
  return properties;
}

}  // namespace deepslam::convex
