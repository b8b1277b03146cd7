// Volume, centre and inertia of a body that fills a closed mesh evenly.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::convex {

struct MassProperties {
  double volume_m3 = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  // Of density 1, about the centre: moments along the principal axes, ascending, and these axes.
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero();
  Eigen::Quaterniond mesh_from_axes = Eigen::Quaterniond::Identity();
};

[[nodiscard]] double VolumeOf(const TriangleMesh& closed);

// Sums over the faces (Eberly, Polyhedral Mass Properties Revisited). All zero where the volume is
// not positive.
[[nodiscard]] MassProperties MassPropertiesOf(const TriangleMesh& closed);

}  // namespace deepslam::convex
