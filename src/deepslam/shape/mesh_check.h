// What a mesh is: closed, oriented, two-manifold. Vertices at equal places count as one.
#pragma once

#include <string>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::shape {

struct MeshCheck {
  bool valid =
      false;  // indices in range, coordinates finite, no face with two equal corners, not empty
  bool closed = false;  // every edge has two faces
  bool oriented =
      false;  // the two faces of every edge run along it in opposite directions, and volume > 0
  bool two_manifold = false;  // closed, and the faces round every vertex form one fan
  int num_components = 0;
  double volume_m3 = 0;  // signed; in cubed units of the mesh where it is not in metres
  std::string fault;     // the first fault found, with its face or vertex; empty = none

  [[nodiscard]] bool ok() const { return valid && closed && oriented && two_manifold; }
};

[[nodiscard]] MeshCheck CheckMesh(const TriangleMesh& mesh);

}  // namespace deepslam::shape
