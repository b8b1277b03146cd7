// The binary part of a glTF file while it grows: buffer views and the accessors on them. Every
// accessor has a view of its own, aligned to 4 bytes.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "deepslam/gltf/render_mesh.h"

namespace tinygltf {
class Model;
}  // namespace tinygltf

namespace deepslam::gltf {

// Adds to `model`, which outlives it. Each call gives the index of what was added. Without `store`
// an accessor has no view: Draco fills it.
class GlbAccessors {
 public:
  explicit GlbAccessors(tinygltf::Model& model) : model_(model) {}

  // `target`: what the bytes are for, as glTF numbers it; 0 = unsaid.
  int AddView(const void* data, std::size_t size, int target);
  // With their bounds, as glTF asks of positions; not empty.
  int AddPositions(const std::vector<Eigen::Vector3f>& points, bool store);
  int AddVectors(const std::vector<Eigen::Vector3f>& vectors, bool store);
  int AddColours(const RenderMesh& mesh, bool store);
  int AddIndices(const RenderMesh& mesh, bool store);

  // All bytes so far, of which none are left here.
  [[nodiscard]] std::vector<unsigned char> TakeBytes();

 private:
  int AddAccessor(int view, int type, int component_type, std::size_t count, bool normalised);

  tinygltf::Model& model_;
  std::vector<unsigned char> bytes_;
};

}  // namespace deepslam::gltf
