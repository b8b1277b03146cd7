// A glTF file while it grows: meshes, lines and nodes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/gltf/draco_encode.h"
#include "deepslam/gltf/encoded_meshes.h"
#include "deepslam/gltf/glb_accessors.h"
#include "deepslam/gltf/glb_materials.h"
#include "deepslam/gltf/render_mesh.h"
#include "deepslam/gltf/scene_writer.h"

namespace tinygltf {
class Model;
class Node;
struct Primitive;
}  // namespace tinygltf

namespace deepslam::gltf {

inline constexpr double kSmoothDeg = 180;  // crease angle that nothing exceeds

struct MeshStyle {
  std::string material_name;
  Rgb8 plain_colour;  // where the mesh has no colours of its own
  bool double_sided = false;
  bool closed = true;
  double crease_angle_deg = kSmoothDeg;
  bool class_variant = false;  // coloured meshes: `plain_colour` as a second appearance
  double opacity = 1;
};

// Options and meshes outlive it. Meshes come in the axes of the map and are turned into glTF's.
class GlbBuilder {
 public:
  // `meshes`: those that were made ready beforehand; others are made when they are added.
  GlbBuilder(const GltfOptions& options, const EncodedMeshes& meshes);
  ~GlbBuilder();
  GlbBuilder(const GlbBuilder&) = delete;
  GlbBuilder& operator=(const GlbBuilder&) = delete;

  [[nodiscard]] tinygltf::Model& model() { return *model_; }

  int AddNode(tinygltf::Node node, bool to_scene);
  // The mesh's index; -1 where it has no faces.
  Result<int> AddMesh(const std::string& name, const TriangleMesh& source, const MeshStyle& style);
  // Points in glTF's axes.
  int AddLine(const std::string& name, const std::vector<Eigen::Vector3f>& points, Rgb8 colour);

  // The file's bytes; the builder is done then.
  [[nodiscard]] std::string Finish();

 private:
  int AddMeshOf(const std::string& name, const tinygltf::Primitive& primitive);
  void FillAccessors(const RenderMesh& mesh, bool store, tinygltf::Primitive& primitive);
  Status FillDraco(const EncodedMesh& encoded, bool closed, tinygltf::Primitive& primitive);
  Status FillDraco(const Result<DracoPayload>& payload, tinygltf::Primitive& primitive);

  const GltfOptions& options_;
  const EncodedMeshes& meshes_;
  const std::unique_ptr<tinygltf::Model> model_;
  GlbAccessors accessors_;
  GlbMaterials materials_;
  std::vector<int> scene_nodes_;
};

}  // namespace deepslam::gltf
