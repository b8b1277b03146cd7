#include "deepslam/gltf/scene_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <exception>
#include <functional>
#include <numbers>
#include <set>
#include <sstream>
#include <utility>

#include "deepslam/core/parallel_in_order.h"
#include "deepslam/core/utf8.h"
#include "deepslam/gltf/check_scene.h"
#include "deepslam/gltf/draco_mesh.h"
#include "deepslam/gltf/encoded_meshes.h"
#include "deepslam/gltf/render_mesh.h"
#include "deepslam/gltf/scene_files.h"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

namespace deepslam::gltf {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kSmooth_deg = 180;  // crease angle that nothing exceeds
constexpr double kRoughness = 0.8;
constexpr Rgb8 kWhite{255, 255, 255};
constexpr Rgb8 kGroundColour{176, 170, 160};
constexpr Rgb8 kTrajectoryColour{230, 80, 30};
constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr const char* kVariants = "KHR_materials_variants";
constexpr int kAppearance = 0;  // places in the list of variants
constexpr int kClassColour = 1;

using ColourKey = std::array<std::uint8_t, 3>;
ColourKey Key(Rgb8 colour) { return {colour.r, colour.g, colour.b}; }

tinygltf::Value StringValue(const std::string& text) { return tinygltf::Value(ToValidUtf8(text)); }

std::vector<double> ToVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// The whole file while it grows. Every accessor has a buffer view of its own, aligned to 4 bytes.
class GlbBuilder {
 public:
  GlbBuilder(const GltfOptions& options, const EncodedMeshes& meshes)
      : options_(options), meshes_(meshes) {}

  tinygltf::Model& model() { return model_; }

  int AddNode(tinygltf::Node node, bool to_scene) {
    const int index = static_cast<int>(model_.nodes.size());
    model_.nodes.push_back(std::move(node));
    if (to_scene) scene_nodes_.push_back(index);
    return index;
  }

  int AddMaterial(const std::string& name, Rgb8 colour, bool double_sided) {
    return AddMaterial(name, {.base = colour, .double_sided = double_sided});
  }

  struct MeshStyle {
    std::string material_name;
    Rgb8 plain_colour;  // where the mesh has no colours of its own
    bool double_sided = false;
    bool closed = true;
    double crease_angle_deg = kSmooth_deg;
    bool class_variant = false;  // coloured meshes: `plain_colour` as a second appearance
  };

  Result<int> AddMesh(const std::string& name, const TriangleMesh& source, const MeshStyle& style) {
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
    primitive.material = AddMaterial(style.material_name,
                                     mesh.colours.empty() ? style.plain_colour : kWhite,
                                     style.double_sided);
    if (style.class_variant && !mesh.colours.empty()) AddClassVariant(style, primitive);
    if (options_.draco) {
      const Status status = FillDraco(*encoded, style.closed, primitive);
      if (!status) return status.error();
    } else {
      FillPlain(mesh, primitive);
    }
    return AddMeshOf(name, primitive);
  }

  int AddLine(const std::string& name, const std::vector<Eigen::Vector3f>& points, Rgb8 colour) {
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_LINE_STRIP;
    primitive.material = AddMaterial(name, colour, false);
    primitive.attributes["POSITION"] = AddPositions(points, true);
    return AddMeshOf(name, primitive);
  }

  std::string Finish() {
    tinygltf::Scene scene;
    scene.name = "scene";
    scene.nodes = scene_nodes_;
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
    if (!bytes_.empty()) {
      tinygltf::Buffer buffer;
      // The writer pads the chunk, not the buffer; views are padded already.
      buffer.data = std::move(bytes_);
      model_.buffers.push_back(std::move(buffer));
    }
    std::ostringstream stream;
    tinygltf::TinyGLTF writer;
    writer.WriteGltfSceneToStream(&model_, stream, false, true);
    return std::move(stream).str();
  }

 private:
  struct Surface {
    Rgb8 base;
    Rgb8 glow{0, 0, 0};  // shown whatever light and vertex colours there are
    bool double_sided = false;
  };

  int AddMaterial(const std::string& name, const Surface& surface) {
    const auto key = std::tuple(name, Key(surface.base), Key(surface.glow), surface.double_sided);
    const auto found = materials_.find(key);
    if (found != materials_.end()) return found->second;
    const auto linear = [](Rgb8 c) {
      return std::vector<double>{LinearFromSrgb(c.r) / 65535.0,
                                 LinearFromSrgb(c.g) / 65535.0,
                                 LinearFromSrgb(c.b) / 65535.0};
    };
    tinygltf::Material material;
    material.name = ToValidUtf8(name);
    material.pbrMetallicRoughness.baseColorFactor = linear(surface.base);
    material.pbrMetallicRoughness.baseColorFactor.push_back(1.0);
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.pbrMetallicRoughness.roughnessFactor = kRoughness;
    material.emissiveFactor = linear(surface.glow);
    material.doubleSided = surface.double_sided;
    const int index = static_cast<int>(model_.materials.size());
    model_.materials.push_back(material);
    materials_[key] = index;
    return index;
  }

  void UseExtension(const char* name, bool required) {
    const auto add = [&](std::vector<std::string>& names) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
    };
    add(model_.extensionsUsed);
    if (required) add(model_.extensionsRequired);
  }

  // Vertex colours multiply the base colour in every material, so the class colour is one that
  // glows: flat, as class colours of segmentations are.
  void AddClassVariant(const MeshStyle& style, tinygltf::Primitive& primitive) {
    const int flat = AddMaterial(style.material_name + " (class colour)",
                                 {.base = {0, 0, 0}, .glow = style.plain_colour});
    tinygltf::Value::Array mappings;
    for (const auto& [variant, material] :
         {std::pair(kAppearance, primitive.material), std::pair(kClassColour, flat)}) {
      tinygltf::Value::Object mapping;
      mapping["material"] = tinygltf::Value(material);
      mapping["variants"] = tinygltf::Value(tinygltf::Value::Array{tinygltf::Value(variant)});
      mappings.emplace_back(std::move(mapping));
    }
    tinygltf::Value::Object extension;
    extension["mappings"] = tinygltf::Value(std::move(mappings));
    primitive.extensions[kVariants] = tinygltf::Value(std::move(extension));
    UseExtension(kVariants, false);
    if (model_.extensions.count(kVariants) != 0) return;
    tinygltf::Value::Array variants;
    for (const char* name : {"appearance", "class"}) {
      tinygltf::Value::Object variant;
      variant["name"] = tinygltf::Value(std::string(name));
      variants.emplace_back(std::move(variant));
    }
    tinygltf::Value::Object list;
    list["variants"] = tinygltf::Value(std::move(variants));
    model_.extensions[kVariants] = tinygltf::Value(std::move(list));
  }

  int AddMeshOf(const std::string& name, const tinygltf::Primitive& primitive) {
    tinygltf::Mesh mesh;
    mesh.name = ToValidUtf8(name);
    mesh.primitives.push_back(primitive);
    model_.meshes.push_back(std::move(mesh));
    return static_cast<int>(model_.meshes.size()) - 1;
  }

  int AddView(const void* data, std::size_t size, int target) {
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

  int AddAccessor(int view, int type, int component_type, std::size_t count, bool normalised) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.type = type;
    accessor.componentType = component_type;
    accessor.count = count;
    accessor.normalized = normalised;
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  // Without `store`, an accessor that Draco fills.
  int AddPositions(const std::vector<Eigen::Vector3f>& points, bool store) {
    Eigen::Vector3f low = points.front();
    Eigen::Vector3f high = low;
    for (const Eigen::Vector3f& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const int index = AddVectors(points, store);
    tinygltf::Accessor& accessor = model_.accessors[static_cast<std::size_t>(index)];
    accessor.minValues = ToVector(low.cast<double>());
    accessor.maxValues = ToVector(high.cast<double>());
    return index;
  }

  int AddVectors(const std::vector<Eigen::Vector3f>& vectors, bool store) {
    static_assert(sizeof(Eigen::Vector3f) == 12);
    const int view =
        store ? AddView(vectors.data(), vectors.size() * 12, TINYGLTF_TARGET_ARRAY_BUFFER) : -1;
    return AddAccessor(
        view, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, vectors.size(), false);
  }

  int AddColours(const RenderMesh& mesh, bool store) {
    const int view =
        store ? AddView(mesh.colours.data(), mesh.colours.size() * 8, TINYGLTF_TARGET_ARRAY_BUFFER)
              : -1;
    return AddAccessor(view,
                       TINYGLTF_TYPE_VEC4,
                       TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                       mesh.colours.size(),
                       true);
  }

  int AddIndices(const RenderMesh& mesh, bool store) {
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
      view =
          AddView(mesh.faces.data(), mesh.faces.size() * 12, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    }
    return AddAccessor(view, TINYGLTF_TYPE_SCALAR, type, 3 * mesh.faces.size(), false);
  }

  void FillAccessors(const RenderMesh& mesh, bool store, tinygltf::Primitive& primitive) {
    primitive.attributes["POSITION"] = AddPositions(mesh.positions, store);
    primitive.attributes["NORMAL"] = AddVectors(mesh.normals, store);
    if (!mesh.colours.empty()) primitive.attributes["COLOR_0"] = AddColours(mesh, store);
    primitive.indices = AddIndices(mesh, store);
  }

  void FillPlain(const RenderMesh& mesh, tinygltf::Primitive& primitive) {
    FillAccessors(mesh, true, primitive);
  }

  Status FillDraco(const EncodedMesh& encoded, bool closed, tinygltf::Primitive& primitive) {
    if (encoded.draco) return FillDraco(*encoded.draco, primitive);
    return FillDraco(
        DracoEncodeForGltf(encoded.mesh, options_.position_bits, options_.normal_bits, closed),
        primitive);
  }

  Status FillDraco(const Result<DracoPayload>& payload, tinygltf::Primitive& primitive) {
    if (!payload) return payload.error();
    // The accessors tell what a decoder gets, quantisation included.
    FillAccessors(payload->decoded, false, primitive);
    tinygltf::Value::Object attributes;
    attributes["POSITION"] = tinygltf::Value(payload->position_id);
    attributes["NORMAL"] = tinygltf::Value(payload->normal_id);
    if (payload->colour_id >= 0) attributes["COLOR_0"] = tinygltf::Value(payload->colour_id);
    tinygltf::Value::Object extension;
    extension["bufferView"] =
        tinygltf::Value(AddView(payload->bytes.data(), payload->bytes.size(), 0));
    extension["attributes"] = tinygltf::Value(std::move(attributes));
    primitive.extensions[kDraco] = tinygltf::Value(std::move(extension));
    UseExtension(kDraco, true);
    return Ok();
  }

  const GltfOptions& options_;
  const EncodedMeshes& meshes_;
  tinygltf::Model model_;
  std::vector<unsigned char> bytes_;
  std::vector<int> scene_nodes_;
  std::map<std::tuple<std::string, ColourKey, ColourKey, bool>, int> materials_;
};

void SetPose(tinygltf::Node& node, const Pose3& world_from_node_gltf) {
  const Eigen::Quaterniond q = world_from_node_gltf.rotation.normalized();
  node.translation = ToVector(world_from_node_gltf.translation_m);
  node.rotation = {q.x(), q.y(), q.z(), q.w()};
}

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

// Meshes that later objects may use again: plain ones of a known model.
struct SharedMesh {
  const GltfObject* first = nullptr;
  int index = -1;
};
using SharedMeshes = std::map<std::tuple<std::string, std::string, ColourKey>, SharedMesh>;

// Objects of one model differ in size by a factor alone, which goes onto the node.
Status AddObjectMesh(const GltfObject& object,
                     const GltfOptions& options,
                     SharedMeshes& shared,
                     GlbBuilder& builder,
                     tinygltf::Node& node) {
  const bool shareable = !object.model.empty() && object.mesh.colours.empty() &&
                         object.scale_m > 0 && !object.mesh.empty();
  const auto key = std::tuple(object.model, object.class_name, Key(object.class_colour));
  if (const auto found = shared.find(key); shareable && found != shared.end()) {
    const double ratio = object.scale_m / found->second.first->scale_m;
    if (IsScaledCopy(object.mesh, found->second.first->mesh, ratio)) {
      node.mesh = found->second.index;
      if (ratio != 1.0) node.scale = {ratio, ratio, ratio};
      return Ok();
    }
  }
  const Result<int> mesh = builder.AddMesh(node.name,
                                           object.mesh,
                                           {.material_name = object.class_name,
                                            .plain_colour = object.class_colour,
                                            .double_sided = false,
                                            .closed = true,
                                            .crease_angle_deg = options.crease_angle_deg,
                                            .class_variant = true});
  if (!mesh) return Error{mesh.error().code, node.name + ": " + mesh.error().message};
  node.mesh = *mesh;
  if (shareable && *mesh >= 0) shared.emplace(key, SharedMesh{&object, *mesh});
  return Ok();
}

Status AddObject(const GltfObject& object,
                 const GltfOptions& options,
                 std::set<std::string>& taken,
                 SharedMeshes& shared,
                 GlbBuilder& builder) {
  const std::string name = UniqueName(object, taken);
  Status status = CheckMeshInput(object.mesh, name);
  if (status) status = CheckPose(object.world_from_object, name);
  if (status && !(std::isfinite(object.score) && std::isfinite(object.scale_m))) {
    status = InvalidInput(name + ": score or scale is not finite");
  }
  if (!status) return status;
  tinygltf::Node node;
  node.name = name;
  SetPose(node, ToGltfAxes(object.world_from_object));
  node.extras = ObjectExtras(object);
  status = AddObjectMesh(object, options, shared, builder, node);
  if (status) builder.AddNode(std::move(node), true);
  return status;
}

Status AddSurface(const std::string& name,
                  const std::optional<TriangleMesh>& mesh,
                  const GlbBuilder::MeshStyle& style,
                  GlbBuilder& builder) {
  if (!mesh || mesh->empty()) return Ok();
  const Status status = CheckMeshInput(*mesh, name);
  if (!status) return status;
  const Result<int> index = builder.AddMesh(name, *mesh, style);
  if (!index) return Error{index.error().code, name + ": " + index.error().message};
  if (*index < 0) return Ok();
  tinygltf::Node node;
  node.name = name;
  node.mesh = *index;
  builder.AddNode(std::move(node), true);
  return Ok();
}

Status AddTrajectory(const GltfScene& scene, GlbBuilder& builder) {
  std::vector<Eigen::Vector3f> points;
  for (const Pose3& pose : scene.trajectory_world_from_camera) {
    const Status status = CheckPose(pose, "trajectory[" + std::to_string(points.size()) + "]");
    if (!status) return status;
    points.push_back(ToGltfAxes(pose.translation_m).cast<float>());
  }
  if (points.size() < 2) return Ok();
  tinygltf::Node node;
  node.name = "trajectory";
  node.mesh = builder.AddLine("trajectory", points, kTrajectoryColour);
  builder.AddNode(std::move(node), true);
  return Ok();
}

Status AddKeyframes(const GltfScene& scene, const GltfOptions& options, GlbBuilder& builder) {
  const PinholeCamera& camera = scene.camera;
  const bool known = camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0;
  if (!options.cameras || !known || scene.keyframes.empty()) return Ok();
  tinygltf::Camera perspective;
  perspective.type = "perspective";
  perspective.name = "sensor";
  perspective.perspective.yfov = 2.0 * std::atan(0.5 * camera.height / camera.fy);
  perspective.perspective.aspectRatio = (camera.width / camera.fx) / (camera.height / camera.fy);
  perspective.perspective.znear = 0.05;
  perspective.perspective.zfar = options.max_frustum_m;
  builder.model().cameras.push_back(perspective);
  tinygltf::Node parent;
  parent.name = "keyframes";
  for (const GltfKeyframe& keyframe : scene.keyframes) {
    std::string number = std::to_string(keyframe.frame);
    number.insert(0, number.size() < 6 ? 6 - number.size() : 0, '0');
    tinygltf::Node node;
    node.name = "keyframe_" + number;
    const Status status = CheckPose(keyframe.world_from_camera, node.name);
    if (!status) return status;
    SetPose(node, GltfCameraPose(keyframe.world_from_camera));
    node.camera = 0;
    parent.children.push_back(builder.AddNode(std::move(node), false));
  }
  builder.AddNode(std::move(parent), true);
  return Ok();
}

tinygltf::Value AssetExtras(const GltfScene& scene) {
  tinygltf::Value::Object extras;
  for (const auto& [key, value] : scene.provenance) extras[ToValidUtf8(key)] = StringValue(value);
  std::set<std::string> credits;
  for (const GltfObject& object : scene.objects) {
    if (!object.credit.empty()) credits.insert(ToValidUtf8(object.credit));
  }
  tinygltf::Value::Array list;
  for (const std::string& credit : credits) list.emplace_back(credit);
  if (!list.empty()) extras["credits"] = tinygltf::Value(std::move(list));
  return extras.empty() ? tinygltf::Value() : tinygltf::Value(std::move(extras));
}

Result<std::string> WriteScene(const GltfScene& scene,
                               const GltfOptions& options,
                               const EncodedMeshes& meshes,
                               bool objects_alone) {
  GlbBuilder builder(options, meshes);
  tinygltf::Asset& asset = builder.model().asset;
  asset.version = "2.0";
  asset.generator = ToValidUtf8(scene.generator);
  asset.extras = AssetExtras(scene);
  std::set<std::string> taken = {"ground", "room", "trajectory", "keyframes"};
  SharedMeshes shared;
  Status status;
  for (const GltfObject& object : scene.objects) {
    status = AddObject(object, options, taken, shared, builder);
    if (!status) return status.error();
  }
  if (objects_alone) return builder.Finish();
  const GlbBuilder::MeshStyle ground_style{.material_name = "ground",
                                           .plain_colour = kGroundColour,
                                           .double_sided = true,
                                           .closed = false};
  const GlbBuilder::MeshStyle room_style{
      .material_name = "room", .plain_colour = kWhite, .double_sided = false, .closed = false};
  status = AddSurface("ground", scene.ground, ground_style, builder);
  if (status) status = AddSurface("room", scene.room, room_style, builder);
  if (status) status = AddTrajectory(scene, builder);
  if (status) status = AddKeyframes(scene, options, builder);
  if (!status) return status.error();
  return builder.Finish();
}

Result<std::string> WriteOrSay(const GltfScene& scene,
                               GltfOptions options,
                               const EncodedMeshes& meshes,
                               const GlbKind& kind) {
  options.draco = kind.draco;
  try {
    return WriteScene(scene, options, meshes, kind.objects_alone);
  } catch (const std::exception& e) {
    return Failed(std::string("glTF: ") + e.what());
  }
}

// The largest first. Of objects of one model without colours only the first, which the others will
// mostly share.
std::vector<EncodedMeshes::Wanted> MeshesOf(const GltfScene& scene, const GltfOptions& options) {
  std::vector<EncodedMeshes::Wanted> wanted;
  for (const std::optional<TriangleMesh>& surface :
       {std::cref(scene.room), std::cref(scene.ground)})
    if (surface) wanted.push_back({&*surface, kRadPerDeg * kSmooth_deg, false});
  std::set<std::string> models;
  for (const GltfObject& object : scene.objects) {
    const bool shares = !object.model.empty() && object.mesh.colours.empty();
    if (!shares || models.insert(object.model).second)
      wanted.push_back({&object.mesh, kRadPerDeg * options.crease_angle_deg, true});
  }
  std::ranges::stable_sort(wanted, std::greater(), [](const EncodedMeshes::Wanted& mesh) {
    return mesh.source->faces.size();
  });
  return wanted;
}

}  // namespace

Result<std::string> WriteGlb(const GltfScene& scene, const GltfOptions& options) {
  const GlbKind kind{options.draco, false};
  return WriteOrSay(scene, options, EncodedMeshes({}), kind);
}

std::vector<Result<std::string>> WriteGlbs(const GltfScene& scene,
                                           const GltfOptions& options,
                                           std::span<const GlbKind> kinds) {
  EncodedMeshes meshes(MeshesOf(scene, options));
  ParallelInOrder(meshes.size(), [&](std::size_t n) { meshes.Render(n); });
  std::vector<Result<std::string>> files(kinds.size(), Result<std::string>(std::string()));
  // Files without compression are written while meshes are compressed for the others.
  std::vector<std::function<void()>> first, then;
  if (std::ranges::any_of(kinds, &GlbKind::draco)) {
    for (std::size_t n = 0; n < meshes.size(); ++n)
      first.emplace_back([&, n] { meshes.Compress(n, options); });
  }
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    (kinds[k].draco ? then : first).emplace_back([&, k] {
      files[k] = WriteOrSay(scene, options, meshes, kinds[k]);
    });
  }
  for (const auto& tasks : {std::cref(first), std::cref(then)})
    ParallelInOrder(tasks.get().size(), [&](std::size_t n) { tasks.get()[n](); });
  return files;
}

}  // namespace deepslam::gltf
