#include "deepslam/gltf/object_nodes.h"

#include <cmath>
#include <utility>

#include "deepslam/core/utf8.h"
#include "deepslam/gltf/check_scene.h"
#include "deepslam/gltf/render_mesh.h"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

namespace deepslam::gltf {
namespace {

tinygltf::Value ObjectExtras(const GltfObject& object) {
  tinygltf::Value::Array views;
  for (const int view : object.views) views.emplace_back(view);
  tinygltf::Value::Object extras;
  extras["class"] = StringValue(object.class_name);
  extras["instance"] = tinygltf::Value(object.instance);
  extras["score"] = tinygltf::Value(object.score);
  extras["prior"] = StringValue(object.source);
  extras["views"] = tinygltf::Value(std::move(views));
  if (!object.credit.empty()) extras["credit"] = StringValue(object.credit);
  return tinygltf::Value(std::move(extras));
}

tinygltf::Value PartExtras(const GltfPart& part) {
  tinygltf::Value::Array rooms;
  for (const int room : part.rooms) rooms.emplace_back(room);
  tinygltf::Value::Object extras;
  extras["layout"] = StringValue(part.kind);
  extras["id"] = tinygltf::Value(part.id);
  extras["rooms"] = tinygltf::Value(std::move(rooms));
  if (part.wall) extras["wall"] = tinygltf::Value(*part.wall);
  for (const auto& [name, figure] : part.figures)
    extras[ToValidUtf8(name)] = tinygltf::Value(std::isfinite(figure) ? figure : 0.0);
  return tinygltf::Value(std::move(extras));
}

}  // namespace

tinygltf::Value StringValue(const std::string& text) { return tinygltf::Value(ToValidUtf8(text)); }

void SetPose(const Pose3& world_from_node_gltf, tinygltf::Node& node) {
  const Eigen::Vector3d& t = world_from_node_gltf.translation_m;
  const Eigen::Quaterniond q = world_from_node_gltf.rotation.normalized();
  node.translation = {t.x(), t.y(), t.z()};
  node.rotation = {q.x(), q.y(), q.z(), q.w()};
}

ObjectNodes::ObjectNodes(const GltfOptions& options, GlbBuilder& builder)
    : options_(options),
      builder_(builder),
      taken_names_({"ground", "room", "trajectory", "keyframes"}) {}

// Objects of one model differ in size by a factor alone, which goes onto the node.
Status ObjectNodes::AddMesh(const GltfObject& object, tinygltf::Node& node) {
  const bool shareable = !object.model.empty() && object.mesh.colours.empty() &&
                         object.scale_m > 0 && !object.mesh.empty();
  const auto key = std::tuple(object.model, object.class_name, Key(object.class_colour));
  if (const auto found = shared_.find(key); shareable && found != shared_.end()) {
    const double ratio = object.scale_m / found->second.first->scale_m;
    if (IsScaledCopy(object.mesh, found->second.first->mesh, ratio)) {
      node.mesh = found->second.index;
      if (ratio != 1.0) node.scale = {ratio, ratio, ratio};
      return Ok();
    }
  }
  const Result<int> mesh = builder_.AddMesh(node.name,
                                            object.mesh,
                                            {.material_name = object.class_name,
                                             .plain_colour = object.class_colour,
                                             .double_sided = false,
                                             .closed = true,
                                             .crease_angle_deg = GltfOptions::kCreaseAngle_deg,
                                             .class_variant = true});
  if (!mesh) return Error{mesh.error().code, node.name + ": " + mesh.error().message};
  node.mesh = *mesh;
  if (shareable && *mesh >= 0) shared_.emplace(key, SharedMesh{&object, *mesh});
  return Ok();
}

Status ObjectNodes::Add(const GltfObject& object) {
  const std::string name = UniqueName(object, taken_names_);
  Status status = CheckMeshInput(object.mesh, name);
  if (status) status = CheckPose(object.world_from_object, name);
  if (status && !(std::isfinite(object.score) && std::isfinite(object.scale_m))) {
    status = InvalidInput(name + ": score or scale is not finite");
  }
  if (!status) return status;
  tinygltf::Node node;
  node.name = name;
  SetPose(ToGltfAxes(object.world_from_object), node);
  node.extras = ObjectExtras(object);
  status = AddMesh(object, node);
  if (status) builder_.AddNode(std::move(node), true);
  return status;
}

Status ObjectNodes::Add(const GltfPart& part) {
  const std::string name = UniqueName(part.name, taken_names_);
  const Status status = CheckMeshInput(part.mesh_world, name);
  if (!status) return status;
  tinygltf::Node node;
  node.name = name;
  node.extras = PartExtras(part);
  const Result<int> mesh = builder_.AddMesh(name,
                                            part.mesh_world,
                                            {.material_name = part.kind,
                                             .plain_colour = part.colour,
                                             .double_sided = false,
                                             .closed = true,
                                             .crease_angle_deg = GltfOptions::kCreaseAngle_deg,
                                             .class_variant = false,
                                             .opacity = part.opacity});
  if (!mesh) return Error{mesh.error().code, name + ": " + mesh.error().message};
  node.mesh = *mesh;
  builder_.AddNode(std::move(node), true);
  return Ok();
}

}  // namespace deepslam::gltf
