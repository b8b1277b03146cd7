// What a physics engine has to know of a thing.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam {

// Frame of the thing: m.
struct RigidBody {
  bool free = false;  // false: it stays where it is
  double mass_kg = 1;
  Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();
  Eigen::Vector3d inertia_kg_m2 = Eigen::Vector3d::Ones();  // principal moments about the centre
  Eigen::Quaterniond thing_from_axes = Eigen::Quaterniond::Identity();  // principal axes
  // Convex, closed: they collide in place of its mesh. None: the mesh itself does.
  std::vector<TriangleMesh> pieces;
};

}  // namespace deepslam
