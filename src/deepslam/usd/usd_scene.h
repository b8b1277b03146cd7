// A labelled scene as Universal Scene Description holds it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/shape/rigid_body.h"

namespace deepslam::usd {

// An Xform with a mesh in it.
struct UsdPrim {
  std::string name;   // any; becomes an identifier (core/identifiers.h), and is kept as displayName
  std::string label;  // semantic class
  Pose3 world_from_prim;
  TriangleMesh mesh;           // frame of the prim, m; may be empty
  Rgb8 colour{160, 160, 160};  // sRGB, where the mesh has no colours
  double opacity = 1;
  bool two_sided = false;  // else it is seen from where its normals point alone
  // Custom data `deepslam`.
  std::map<std::string, std::string> texts;
  std::map<std::string, double> numbers;
  std::optional<RigidBody> body;  // frame of the prim; nothing: no physics
};

struct UsdGroup {
  std::string name;  // an identifier
  std::vector<UsdPrim> prims;
};

struct UsdScene {
  std::vector<UsdGroup> groups;
  std::map<std::string, std::string> provenance;  // custom data of the layer
};

}  // namespace deepslam::usd
