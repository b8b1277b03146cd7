// Whether a camera may stand where its way leads it: neither in a piece of furniture nor against it.
// Under a table or in the corner of an L-shaped sofa it may, though it is within their boxes.
#pragma once

#include <Eigen/Core>

#include "deepslam/render/ray_scene.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::synth {

class CameraClearance {
 public:
  // Closed or not; a mesh that RayScene takes.
  explicit CameraClearance(const TriangleMesh& mesh_object);

  // Whether a surface is nearer than `margin_m`, or surfaces stand in nearly every direction.
  [[nodiscard]] bool Blocked(const Eigen::Vector3d& p_object, double margin_m) const;

 private:
  render::RayScene scene_;
};

}  // namespace deepslam::synth
