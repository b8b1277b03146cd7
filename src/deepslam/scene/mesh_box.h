// The box of a mesh's faces; vertices that no face uses do not count.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Geometry>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam {

// In the mesh's frame; empty without faces.
inline Eigen::AlignedBox3f BoxOfFaces(const TriangleMesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const std::array<std::uint32_t, 3>& face : mesh.faces) {
    for (const std::uint32_t corner : face) box.extend(mesh.vertices[corner]);
  }
  return box;
}

}  // namespace deepslam
