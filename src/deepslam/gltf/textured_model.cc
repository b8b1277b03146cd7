#include "deepslam/gltf/textured_model.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/gltf/findings.h"
#include "deepslam/gltf/gltf_document.h"
#include "deepslam/gltf/gltf_materials.h"
#include "deepslam/gltf/gltf_nodes.h"
#include "deepslam/gltf/json_place.h"
#include "deepslam/gltf/primitive_geometry.h"

namespace deepslam::gltf {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// What may be required of a reader and changes nothing of what is read here, or is read.
bool IsKnownExtension(const std::string& name) {
  static const std::vector<std::string> kKnown = {kDracoExtension,
                                                  "KHR_mesh_quantization",
                                                  "KHR_lights_punctual",
                                                  "KHR_node_visibility",
                                                  "KHR_xmp_json_ld",
                                                  "EXT_texture_webp"};
  return std::find(kKnown.begin(), kKnown.end(), name) != kKnown.end() ||
         name.starts_with("KHR_materials_") || name.starts_with("KHR_texture_");
}

void CheckExtensions(const JsonPlace& required) {
  for (std::size_t n = 0; n < required.Size(); ++n) {
    if (!IsKnownExtension(required.At(n).Text()))
      required.Error(required.At(n).Dump() + " is not supported; export without it");
  }
}

// Strips turn every second triangle round; fans share their first corner. Triangles without area
// are left out, with which strips are joined.
std::vector<Triangle> TrianglesOf(const PrimitiveGeometry& geometry, std::uint64_t mode) {
  std::vector<Triangle> triangles;
  const std::vector<std::uint32_t>& corners = geometry.corners;
  if (geometry.is_compressed) mode = kTriangles;
  const std::size_t step = mode == kTriangles ? 3 : 1;
  for (std::size_t n = 0; n + 2 < corners.size(); n += step) {
    Triangle face = {corners[n], corners[n + 1], corners[n + 2]};
    if (mode == kTriangleStrip && n % 2 == 1) std::swap(face[0], face[1]);
    if (mode == kTriangleFan) face[0] = corners[0];
    const bool has_area = face[0] != face[1] && face[1] != face[2] && face[2] != face[0];
    if (has_area || geometry.is_compressed) triangles.push_back(face);
  }
  return triangles;
}

class ModelReader {
 public:
  ModelReader(const GltfDocument& document, const ResourceLookup& beside, std::size_t max_faces)
      : root_(document.root()),
        buffers_(root_, document.binary, beside),
        max_faces_(max_faces),
        errors_before_(root_.num_errors()) {}

  TexturedMesh Read() {
    CheckExtensions(root_["extensionsRequired"]);
    GltfMaterials materials = ReadMaterials(root_, buffers_);
    mesh_.materials = std::move(materials.surfaces);
    mesh_.textures = std::move(materials.textures);
    placements_ = std::move(materials.placements);
    if (ok()) ReadScene();
    if (!has_colours_) mesh_.colours.clear();
    return std::move(mesh_);
  }

 private:
  [[nodiscard]] bool ok() const { return root_.num_errors() == errors_before_; }

  void ReadScene() {
    const JsonPlace meshes = root_["meshes"];
    std::vector<std::pair<int, Eigen::Affine3d>> pending;
    for (const int root : RootsOfDefaultScene(root_))
      pending.emplace_back(root, Eigen::Affine3d::Identity());
    std::vector<bool> visited(root_["nodes"].Size(), false);
    while (!pending.empty() && ok()) {
      const auto [n, scene_from_parent] = pending.back();
      pending.pop_back();
      const auto number = static_cast<std::size_t>(n);
      if (visited[number])
        return root_["nodes"].At(number).Error("has several parents, or is its own");
      visited[number] = true;
      const GltfNode node = ReadNode(root_, number);
      if (!ok()) return;
      const Eigen::Affine3d scene_from_node = scene_from_parent * node.ParentFromNode();
      for (const int child : node.children) pending.emplace_back(child, scene_from_node);
      if (node.mesh >= 0) AddMesh(meshes.At(static_cast<std::size_t>(node.mesh)), scene_from_node);
    }
  }

  void AddMesh(const JsonPlace& mesh, const Eigen::Affine3d& scene_from_node) {
    const JsonPlace primitives = mesh["primitives"];
    const std::size_t num_primitives = primitives.Size();
    for (std::size_t p = 0; p < num_primitives && ok(); ++p)
      AddPrimitive(primitives.At(p), scene_from_node);
  }

  void AddPrimitive(const JsonPlace& primitive, const Eigen::Affine3d& scene_from_node) {
    const std::uint64_t mode = primitive["mode"].Whole(kTriangles);
    if (mode < kTriangles) return;  // points, lines
    if (mode > kTriangleFan) return primitive["mode"].Error(std::to_string(mode) + " is unknown");
    const int material = primitive["material"].Index(mesh_.materials.size());
    const TexturePlacement placement =
        material < 0 ? TexturePlacement() : placements_[static_cast<std::size_t>(material)];
    const std::optional<PrimitiveGeometry> geometry =
        ReadPrimitive(buffers_,
                      primitive,
                      {.texture_set = placement.set, .colours = true, .max_faces = max_faces_});
    if (!geometry || !ok()) return;
    const std::vector<Triangle> triangles = TrianglesOf(*geometry, mode);
    const std::size_t num_faces = mesh_.faces.size() + triangles.size();
    const std::size_t num_vertices = mesh_.vertices.size() + geometry->positions.size();
    if (num_faces > max_faces_ || num_vertices > 3 * max_faces_) {
      return primitive.Error("brings the model to " +
                             std::to_string(std::max(num_faces, num_vertices / 3)) +
                             " faces, more than " + std::to_string(max_faces_) +
                             "; make it coarser (Blender: Decimate)");
    }
    AddFaces(*geometry, triangles, material, placement, scene_from_node);
  }

  void AddFaces(const PrimitiveGeometry& geometry,
                const std::vector<Triangle>& triangles,
                int material,
                const TexturePlacement& placement,
                const Eigen::Affine3d& scene_from_node) {
    const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
    for (const Eigen::Vector3f& p : geometry.positions)
      mesh_.vertices.push_back(scene_from_node * p.cast<double>());
    has_colours_ |= !geometry.colours.empty();
    for (const Eigen::Vector3f& c : geometry.colours) mesh_.colours.push_back(DisplayFromLinear(c));
    mesh_.colours.resize(mesh_.vertices.size(), Eigen::Vector3f::Ones());
    const bool mirrored = scene_from_node.linear().determinant() < 0;
    for (const Triangle& corners : triangles) {
      TexturedMesh::Face face;
      face.material = material;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t corner = corners[mirrored ? 2 - c : c];
        face.vertices[c] = first + corner;
        if (!geometry.places.empty()) face.places[c] = placement(geometry.places[corner]);
      }
      mesh_.faces.push_back(face);
    }
  }

  JsonPlace root_;
  GltfBuffers buffers_;
  std::size_t max_faces_;
  std::size_t errors_before_;
  TexturedMesh mesh_;
  std::vector<TexturePlacement> placements_;  // per material
  bool has_colours_ = false;
};

}  // namespace

Result<TexturedMesh> ReadTexturedModel(std::string_view bytes,
                                       const ResourceLookup& beside,
                                       std::size_t max_faces) {
  Findings findings;
  try {
    const std::optional<GltfDocument> document = OpenGlbOrGltf(bytes, findings);
    if (!document) return InvalidInput("not a readable glTF: " + findings.errors.front());
    TexturedMesh mesh;
    if (findings.ok()) mesh = ModelReader(*document, beside, max_faces).Read();
    if (!findings.ok()) return InvalidInput(findings.errors.front());
    if (mesh.faces.empty())
      return InvalidInput("has no triangles in its scene; export the furniture as a mesh");
    return mesh;
  } catch (const std::exception& e) {
    return InvalidInput(std::string("not a readable glTF: ") + e.what());
  }
}

}  // namespace deepslam::gltf
