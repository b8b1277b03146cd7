#include "deepslam/gltf/glb_builder.h"

#include <cstddef>
#include <sstream>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/core/utf8.h"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

namespace deepslam::gltf {
namespace {

constexpr Rgb8 kWhite{255, 255, 255};
constexpr const char* kDraco = "KHR_draco_mesh_compression";

}  // namespace

GlbBuilder::GlbBuilder(const GltfOptions& options, const EncodedMeshes& meshes)
    : options_(options),
      meshes_(meshes),
      model_(std::make_unique<tinygltf::Model>()),
      accessors_(*model_),
      materials_(*model_) {}

GlbBuilder::~GlbBuilder() = default;

int GlbBuilder::AddNode(tinygltf::Node node, bool to_scene) {
  const int index = static_cast<int>(model_->nodes.size());
  model_->nodes.push_back(std::move(node));
  if (to_scene) scene_nodes_.push_back(index);
  return index;
}

Result<int> GlbBuilder::AddMesh(const std::string& name,
                                const TriangleMesh& source,
                                const MeshStyle& style) {
  const EncodedMesh* encoded = meshes_.Find(source);
  EncodedMesh own;
  if (encoded == nullptr) {
    own.mesh = MakeRenderMesh(source, kRadPerDeg * style.crease_angle_deg);
    encoded = &own;
  }
  const RenderMesh& mesh = encoded->mesh;
  if (mesh.faces.empty()) return -1;
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = materials_.Add(style.material_name,
                                      mesh.colours.empty() ? style.plain_colour : kWhite,
                                      style.double_sided,
                                      style.opacity);
  if (style.class_variant && !mesh.colours.empty())
    materials_.AddClassVariant(style.material_name, style.plain_colour, primitive);
  if (options_.draco) {
    const Status status = FillDraco(*encoded, style.closed, primitive);
    if (!status) return status.error();
  } else {
    FillAccessors(mesh, true, primitive);
  }
  return AddMeshOf(name, primitive);
}

int GlbBuilder::AddLine(const std::string& name,
                        const std::vector<Eigen::Vector3f>& points,
                        Rgb8 colour) {
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_LINE_STRIP;
  primitive.material = materials_.Add(name, colour, false);
  primitive.attributes["POSITION"] = accessors_.AddPositions(points, true);
  return AddMeshOf(name, primitive);
}

std::string GlbBuilder::Finish() {
  tinygltf::Scene scene;
  scene.name = "scene";
  scene.nodes = scene_nodes_;
  model_->scenes.push_back(scene);
  model_->defaultScene = 0;
  if (std::vector<unsigned char> bytes = accessors_.TakeBytes(); !bytes.empty()) {
    tinygltf::Buffer buffer;
    // The writer pads the chunk, not the buffer; views are padded already.
    buffer.data = std::move(bytes);
    model_->buffers.push_back(std::move(buffer));
  }
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  writer.WriteGltfSceneToStream(model_.get(), stream, false, true);
  return std::move(stream).str();
}

int GlbBuilder::AddMeshOf(const std::string& name, const tinygltf::Primitive& primitive) {
  tinygltf::Mesh mesh;
  mesh.name = ToValidUtf8(name);
  mesh.primitives.push_back(primitive);
  model_->meshes.push_back(std::move(mesh));
  return static_cast<int>(model_->meshes.size()) - 1;
}

void GlbBuilder::FillAccessors(const RenderMesh& mesh, bool store, tinygltf::Primitive& primitive) {
  primitive.attributes["POSITION"] = accessors_.AddPositions(mesh.positions, store);
  primitive.attributes["NORMAL"] = accessors_.AddVectors(mesh.normals, store);
  if (!mesh.colours.empty()) primitive.attributes["COLOR_0"] = accessors_.AddColours(mesh, store);
  primitive.indices = accessors_.AddIndices(mesh, store);
}

Status GlbBuilder::FillDraco(const EncodedMesh& encoded,
                             bool closed,
                             tinygltf::Primitive& primitive) {
  if (encoded.draco) return FillDraco(*encoded.draco, primitive);
  return FillDraco(
      DracoEncode(encoded.mesh, options_.position_bits, GltfOptions::kNormalBits, closed),
      primitive);
}

Status GlbBuilder::FillDraco(const Result<DracoPayload>& payload, tinygltf::Primitive& primitive) {
  if (!payload) return payload.error();
  // The accessors tell what a decoder gets, quantisation included.
  FillAccessors(payload->decoded, false, primitive);
  tinygltf::Value::Object attributes;
  attributes["POSITION"] = tinygltf::Value(payload->position_id);
  attributes["NORMAL"] = tinygltf::Value(payload->normal_id);
  if (payload->colour_id >= 0) attributes["COLOR_0"] = tinygltf::Value(payload->colour_id);
  tinygltf::Value::Object extension;
  extension["bufferView"] =
      tinygltf::Value(accessors_.AddView(payload->bytes.data(), payload->bytes.size(), 0));
  extension["attributes"] = tinygltf::Value(std::move(attributes));
  primitive.extensions[kDraco] = tinygltf::Value(std::move(extension));
  UseExtension(kDraco, true, *model_);
  return Ok();
}

}  // namespace deepslam::gltf
