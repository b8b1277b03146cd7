#include "deepslam/gltf/scene_writer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <functional>
#include <set>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/core/parallel_in_order.h"
#include "deepslam/core/utf8.h"
#include "deepslam/gltf/check_scene.h"
#include "deepslam/gltf/draco_encode.h"
#include "deepslam/gltf/encoded_meshes.h"
#include "deepslam/gltf/glb_builder.h"
#include "deepslam/gltf/object_nodes.h"
#include "deepslam/gltf/render_mesh.h"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

namespace deepslam::gltf {
namespace {

constexpr Rgb8 kWhite{255, 255, 255};
constexpr Rgb8 kGroundColour{176, 170, 160};
constexpr Rgb8 kTrajectoryColour{230, 80, 30};

Status AddSurface(const std::string& name,
                  const std::optional<TriangleMesh>& mesh,
                  const MeshStyle& style,
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
  perspective.perspective.zfar = GltfOptions::kMaxFrustum_m;
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
    SetPose(GltfCameraPose(keyframe.world_from_camera), node);
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
  ObjectNodes objects(options, builder);
  Status status;
  for (const GltfObject& object : scene.objects) {
    status = objects.Add(object);
    if (!status) return status.error();
  }
  if (objects_alone) return builder.Finish();
  const MeshStyle ground_style{.material_name = "ground",
                               .plain_colour = kGroundColour,
                               .double_sided = true,
                               .closed = false};
  const MeshStyle room_style{
      .material_name = "room", .plain_colour = kWhite, .double_sided = false, .closed = false};
  for (const GltfPart& part : scene.parts) {
    status = objects.Add(part);
    if (!status) return status.error();
  }
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
std::vector<EncodedMeshes::Wanted> MeshesOf(const GltfScene& scene) {
  std::vector<EncodedMeshes::Wanted> wanted;
  for (const std::optional<TriangleMesh>& surface :
       {std::cref(scene.room), std::cref(scene.ground)})
    if (surface) wanted.push_back({&*surface, kRadPerDeg * kSmoothDeg, false});
  for (const GltfPart& part : scene.parts)
    wanted.push_back({&part.mesh_world, kRadPerDeg * GltfOptions::kCreaseAngle_deg, true});
  std::set<std::string> models;
  for (const GltfObject& object : scene.objects) {
    const bool shares = !object.model.empty() && object.mesh.colours.empty();
    if (!shares || models.insert(object.model).second)
      wanted.push_back({&object.mesh, kRadPerDeg * GltfOptions::kCreaseAngle_deg, true});
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
  EncodedMeshes meshes(MeshesOf(scene));
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

void Describe(OptionsVisitor& visitor, GltfOptions& options) {
  visitor.Field("draco", options.draco, "compress meshes by KHR_draco_mesh_compression");
  visitor.Field("position_bits",
                options.position_bits,
                {static_cast<double>(kMinPositionBits), static_cast<double>(kMaxPositionBits)},
                "1",
                "Draco: bits per coordinate over a mesh's longest side");
  visitor.Field("cameras", options.cameras, "write the keyframes' cameras");
}

}  // namespace deepslam::gltf
