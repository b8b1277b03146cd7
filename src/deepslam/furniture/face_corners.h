// Faces taken out of a mesh, corner by corner, to be cut or divided and put into another.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::furniture {

struct Corner {
  Eigen::Vector3f place;  // in the mesh's frame
  Rgb8 colour;
};

using Face = std::array<Corner, 3>;

// Grey where the mesh has no colours.
inline Face CornersOf(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& face) {
  Face corners;
  for (std::size_t c = 0; c < 3; ++c) {
    corners[c] = {mesh.vertices[face[c]],
                  mesh.colours.empty() ? Rgb8{200, 200, 200} : mesh.colours[face[c]]};
  }
  return corners;
}

// With vertices of its own.
inline void AddFace(const Face& corners, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.faces.push_back({first, first + 1, first + 2});
  for (const Corner& corner : corners) {
    mesh.vertices.push_back(corner.place);
    mesh.colours.push_back(corner.colour);
  }
}

}  // namespace deepslam::furniture
