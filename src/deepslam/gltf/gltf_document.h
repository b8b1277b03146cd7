// A GLB taken apart into plain values, with every index and bound checked on the way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace deepslam::gltf {

// Errors and warnings with their places; the first kMaxFindings of each are kept.
struct Findings {
  std::vector<std::string> errors;
  std::vector<std::string> warnings;

  void Error(const std::string& place, const std::string& what);
  void Warn(const std::string& place, const std::string& what);
};

struct GltfView {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint64_t stride = 0;  // 0 = tightly packed
};

struct GltfAccessor {
  int view = -1;             // -1: filled by Draco
  std::uint64_t offset = 0;  // within the view
  std::uint64_t count = 0;
  int component_type = 0;
  int component_bytes = 0;
  int num_components = 0;
  std::vector<double> min;
  std::vector<double> max;
};

struct GltfPrimitive {
  std::string place;
  std::map<std::string, int> attributes;
  int indices = -1;
  int mode = 4;
  int draco_view = -1;
  std::map<std::string, int> draco_attributes;
};

struct GltfMesh {
  std::vector<GltfPrimitive> primitives;
};

struct GltfNode {
  std::string name;
  int mesh = -1;
  int camera = -1;
  std::array<double, 3> translation = {0, 0, 0};
  std::array<double, 4> rotation = {0, 0, 0, 1};  // x, y, z, w
  std::array<double, 3> scale = {1, 1, 1};
  std::vector<int> children;
  bool is_object = false;  // extras.class is there
  std::string class_name;
  std::optional<std::int64_t> instance;
  std::string prior;
  std::optional<double> score;
};

struct GltfDocument {
  std::string_view binary;  // the BIN chunk, cut to the buffer
  std::vector<GltfView> views;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfMesh> meshes;
  std::vector<GltfNode> nodes;
  std::vector<std::vector<int>> scenes;
  int num_cameras = 0;
  std::vector<std::string> variants;  // of KHR_materials_variants
  bool requires_draco = false;
};

// Nothing when the container or the JSON cannot be read. With errors in `findings` the document may
// hold indices out of range and is not to be used further. Views into `bytes` stay in the result.
[[nodiscard]] std::optional<GltfDocument> ReadGltfDocument(std::string_view bytes,
                                                           Findings& findings);

}  // namespace deepslam::gltf
