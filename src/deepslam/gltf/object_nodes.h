// The nodes of objects in a glTF file.
#pragma once

#include <map>
#include <set>
#include <string>
#include <tuple>

#include "deepslam/core/result.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/gltf/glb_builder.h"
#include "deepslam/gltf/scene_writer.h"

namespace tinygltf {
class Node;
class Value;
}  // namespace tinygltf

namespace deepslam::gltf {

[[nodiscard]] tinygltf::Value StringValue(const std::string& text);

void SetPose(const Pose3& world_from_node_gltf, tinygltf::Node& node);

// Adds objects and parts of the room one by one; options and builder outlive it, and so do the
// objects.
class ObjectNodes {
 public:
  ObjectNodes(const GltfOptions& options, GlbBuilder& builder);

  // Errors name the object.
  Status Add(const GltfObject& object);
  // A part without a mesh is a node without one. Errors name the part.
  Status Add(const GltfPart& part);

 private:
  Status AddMesh(const GltfObject& object, tinygltf::Node& node);

  // Meshes that later objects may use again: plain ones of a known model.
  struct SharedMesh {
    const GltfObject* first = nullptr;
    int index = -1;
  };
  using SharedMeshes = std::map<std::tuple<std::string, std::string, ColourKey>, SharedMesh>;

  const GltfOptions& options_;
  GlbBuilder& builder_;
  std::set<std::string> taken_names_;
  SharedMeshes shared_;
};

}  // namespace deepslam::gltf
