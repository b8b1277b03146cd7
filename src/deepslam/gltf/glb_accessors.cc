#include "deepslam/gltf/glb_accessors.h"

#include <cstdint>
#include <utility>

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

namespace deepslam::gltf {

int GlbAccessors::AddView(const void* data, std::size_t size, int target) {
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = bytes_.size();
  view.byteLength = size;
  view.target = target;
  const auto* begin = static_cast<const unsigned char*>(data);
  bytes_.insert(bytes_.end(), begin, begin + size);
  bytes_.resize((bytes_.size() + 3) / 4 * 4, 0);
  model_.bufferViews.push_back(view);
  return static_cast<int>(model_.bufferViews.size()) - 1;
}

int GlbAccessors::AddAccessor(
    int view, int type, int component_type, std::size_t count, bool normalised) {
  tinygltf::Accessor accessor;
  accessor.bufferView = view;
  accessor.type = type;
  accessor.componentType = component_type;
  accessor.count = count;
  accessor.normalized = normalised;
  model_.accessors.push_back(accessor);
  return static_cast<int>(model_.accessors.size()) - 1;
}

int GlbAccessors::AddPositions(const std::vector<Eigen::Vector3f>& points, bool store) {
  Eigen::Vector3f low = points.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const int index = AddVectors(points, store);
  tinygltf::Accessor& accessor = model_.accessors[static_cast<std::size_t>(index)];
  accessor.minValues = {low.x(), low.y(), low.z()};
  accessor.maxValues = {high.x(), high.y(), high.z()};
  return index;
}

int GlbAccessors::AddVectors(const std::vector<Eigen::Vector3f>& vectors, bool store) {
  static_assert(sizeof(Eigen::Vector3f) == 12);
  const int view =
      store ? AddView(vectors.data(), vectors.size() * 12, TINYGLTF_TARGET_ARRAY_BUFFER) : -1;
  return AddAccessor(
      view, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, vectors.size(), false);
}

int GlbAccessors::AddColours(const RenderMesh& mesh, bool store) {
  const int view =
      store ? AddView(mesh.colours.data(), mesh.colours.size() * 8, TINYGLTF_TARGET_ARRAY_BUFFER)
            : -1;
  return AddAccessor(
      view, TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, mesh.colours.size(), true);
}

int GlbAccessors::AddIndices(const RenderMesh& mesh, bool store) {
  // 65535 itself is the restart value and may not be used.
  const bool small = mesh.positions.size() <= 65535;
  const int type =
      small ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  int view = -1;
  if (store && small) {
    std::vector<std::uint16_t> indices;
    indices.reserve(3 * mesh.faces.size());
    for (const auto& face : mesh.faces) {
      for (const std::uint32_t v : face) indices.push_back(static_cast<std::uint16_t>(v));
    }
    view = AddView(indices.data(), indices.size() * 2, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  } else if (store) {
    view = AddView(mesh.faces.data(), mesh.faces.size() * 12, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  }
  return AddAccessor(view, TINYGLTF_TYPE_SCALAR, type, 3 * mesh.faces.size(), false);
}

std::vector<unsigned char> GlbAccessors::TakeBytes() { return std::exchange(bytes_, {}); }

}  // namespace deepslam::gltf
