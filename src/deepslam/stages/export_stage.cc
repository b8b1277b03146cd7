// export: the labelled scene, the compact map, the object list.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/map_json.h"
#include "deepslam/artifact/objects_csv.h"
#include "deepslam/artifact/scene_json.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/sha256.h"
#include "deepslam/gltf/scene_files.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/floor_surface.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/report/sanity_checks.h"
#include "deepslam/scene/measured_parts.h"
#include "deepslam/shape/voxel_code.h"
#include "deepslam/stages/expand.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/read_side_by_side.h"
#include "deepslam/stages/room_beside.h"
#include "deepslam/stages/scene_files.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// Everything the scene is made of.
struct Content {
  OptimizedMap map;
  std::vector<TriangleMesh> meshes;  // per object
  TriangleMesh room;
  Proposals proposals;
  std::map<std::string, std::string> library_checksums;
  std::map<std::string, std::string> voxels_checksums;  // by model key
  std::vector<KeyframeJoin> joins;                      // loops included
};

// Between which keyframes tracking and the loops measured something.
Result<std::vector<KeyframeJoin>> ReadJoins(const StageContext& context) {
  const Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  const Result<Loops> loops = ReadLoops(context);
  if (!loops.ok()) return loops.error();
  return JoinsOf(*odometry, loops->edges);
}

Status ReadObjects(const StageContext& context, Content& content) {
  Status status = Take(ReadOptimized(context), content.map);
  if (!status.ok()) return status;
  for (const MapObject& object : content.map.map.objects) {
    Result<TriangleMesh> mesh =
        ReadMesh(context, "mesh", fmt::format("objects/{}.ply", ObjectName(object)));
    if (!mesh.ok()) return mesh.error();
    content.meshes.push_back(std::move(mesh).value());
    const Result<std::string> voxels =
        context.Read("loops", fmt::format("models/{}.binvox", object.model));
    if (!voxels.ok()) return voxels.error();
    content.voxels_checksums[object.model] = Sha256Hex(*voxels);
  }
  return Ok();
}

Status ReadLibraryChecksums(const StageContext& context, Content& content) {
  const Result<std::string> models = context.Read("propose", "library_models.json");
  if (!models.ok()) return models.error();
  artifact::JsonReader reader(*models, "propose/library_models.json", "deepslam/library_models", 1);
  for (const auto& [id, checksum] : reader.root()["models"].Members()) {
    content.library_checksums[id] = checksum.String();
  }
  return reader.ok() ? Ok() : Status(reader.error());
}

Result<Content> ReadContent(const StageContext& context) {
  Content content;
  const std::array<std::function<Status()>, 5> readers = {
      [&] { return ReadObjects(context, content); },
      [&] { return Take(ReadCandidates(context, "loops"), content.proposals); },
      [&] { return Take(ReadMesh(context, "fuse", "room.ply"), content.room); },
      [&] { return Take(ReadJoins(context), content.joins); },
      [&] { return ReadLibraryChecksums(context, content); }};
  if (Status status = ReadSideBySide(readers); !status.ok()) return status.error();
  return content;
}

// The seen floor: room points near the ground plane.
std::optional<TriangleMesh> GroundMesh(const Content& content, const Config& config) {
  if (!content.map.has_ground) return std::nullopt;
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3f& vertex : content.room.vertices) {
    if (std::abs(vertex.z()) < kFloorBandM) points.emplace_back(vertex.x(), vertex.y());
  }
  const Result<TriangleMesh> polygon = mesh::GroundPolygon(points, config.ground_polygon);
  if (!polygon.ok()) return std::nullopt;  // floor never seen: the scene goes without
  return mesh::ColouredGround(
      RoundedGround(*polygon), content.room, kFloorBandM, config.ground_polygon.colour_step_m);
}

// A mesh in its class colour alone has no colours of its own: objects of one model can share it
// then.
bool IsPlain(const TriangleMesh& mesh, Rgb8 class_colour) {
  return std::all_of(mesh.colours.begin(), mesh.colours.end(), [&](const Rgb8& colour) {
    return colour == class_colour;
  });
}

gltf::GltfObject ToGltf(const MapObject& object,
                        const TriangleMesh& mesh,
                        const ClassTable& classes,
                        const ExportStageOptions& options) {
  gltf::GltfObject out;
  out.name = ObjectName(object);
  out.class_name = object.class_name;
  out.instance = object.id.value;
  out.score = object.confidence;
  out.source = NameOf(object.source);
  for (const ViewRegistration& view : object.views) out.views.push_back(view.frame.value);
  out.mesh = mesh;
  out.world_from_object = object.world_from_object;
  if (const ObjectClass* object_class = classes.Find(object.class_name)) {
    const auto channel = [&](std::size_t i) {
      return static_cast<std::uint8_t>(object_class->colour_rgb[i]);
    };
    out.class_colour = {channel(0), channel(1), channel(2)};
  }
  if (options.appearance == "class" || IsPlain(mesh, out.class_colour)) out.mesh.colours.clear();
  out.credit = object.credit;
  out.model = object.model;
  out.scale_m = object.scale_m;
  return out;
}

gltf::GltfScene MakeScene(const Content& content, const RunInputs& inputs) {
  const Config& config = inputs.config;
  gltf::GltfScene scene;
  for (std::size_t i = 0; i < content.meshes.size(); ++i) {
    scene.objects.push_back(
        ToGltf(content.map.map.objects[i], content.meshes[i], inputs.classes, config.export_stage));
  }
  scene.ground = GroundMesh(content, config);
  if (config.export_stage.room && !content.room.empty())
    scene.room = RoomBeside(content.room, content.map.map.objects, content.meshes, scene.ground);
  if (config.export_stage.trajectory) {
    for (const TrackedFrame& frame : content.map.frames) {
      scene.trajectory_world_from_camera.push_back(frame.world_from_camera);
    }
    for (const FrameIdx keyframe : content.map.keyframes) {
      scene.keyframes.push_back(
          {keyframe.value,
           content.map.frames[static_cast<std::size_t>(keyframe.value)].world_from_camera});
    }
  }
  scene.camera = inputs.capture->frames->camera();
  scene.generator = fmt::format("deepslam {}", kToolVersion);
  scene.provenance = {{"capture_sha256", inputs.capture->content_hash},
                      {"deepslam_version", std::string(kToolVersion)}};
  return scene;
}

Result<CompactObject> ToMapEntry(const MapObject& object,
                                 const TriangleMesh& mesh,
                                 const Content& content,
                                 const StageContext& context) {
  CompactObject entry{object.id,
                      ObjectName(object),
                      object.class_name,
                      std::clamp(object.confidence, 0.0, 1.0),
                      object.source,
                      object.world_from_object,
                      object.scale_m,
                      Eigen::Vector3d::Zero(),
                      object.credit,
                      object.note,
                      {}};
  Box3 box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.Extend(vertex.cast<double>());
  entry.size_m = box.Size();
  for (const ShapeCandidate& candidate : content.proposals.candidates) {
    if (candidate.id != object.chosen) continue;
    entry.shape.latents = candidate.latents;
    entry.shape.stretch = candidate.stretch;
  }
  if (!object.library_id.empty()) {
    entry.shape.library_id = object.library_id;
    const auto checksum = content.library_checksums.find(object.library_id);
    if (checksum != content.library_checksums.end())
      entry.shape.library_checksum = checksum->second.substr(0, kMapChecksumDigits);
    entry.shape.voxels_checksum =
        content.voxels_checksums.at(object.model).substr(0, kMapChecksumDigits);
  } else if (!mesh.empty()) {  // a network's too: the map is then whole without its decoder
    const Result<VoxelGrid> grid = ReadModel(context, "loops", object.model);
    if (!grid.ok()) return grid.error();
    entry.shape.voxel_code = shape::EncodeVoxels(*grid);
  }
  return entry;
}

// Options of the meshes that are not the defaults.
std::map<std::string, std::string> MeshOptions(const Config& config) {
  const std::set<std::string> sections = {"mesh.surface", "mesh.refine"};
  const std::map<std::string, std::string> defaults = KeyOptions(Config(), sections);
  std::map<std::string, std::string> options = KeyOptions(config, sections);
  std::erase_if(options,
                [&](const auto& option) { return defaults.at(option.first) == option.second; });
  return options;
}

Result<CompactMap> MakeMap(const StageContext& context,
                           const Content& content,
                           const gltf::GltfScene& scene,
                           const RunInputs& inputs) {
  CompactMap map;
  map.tool_version = kToolVersion;
  map.capture_name = inputs.capture->name;
  map.capture_hash = inputs.capture->content_hash;
  if (content.map.has_ground) map.ground_world = content.map.ground_world;
  const RunVerdict verdict = report::CheckRun(content.map, content.joins, inputs.capture->doubts);
  if (scene.ground) map.ground_outline_m = mesh::OutlineOf(*scene.ground);
  for (const gltf::GltfObject& object : scene.objects) {
    map.class_colours[object.class_name] = object.class_colour;
  }
  map.mesh_options = MeshOptions(inputs.config);
  map.verdict = verdict.verdict;
  map.reasons = verdict.reasons;
  for (std::size_t i = 0; i < content.meshes.size(); ++i) {
    Result<CompactObject> entry =
        ToMapEntry(content.map.map.objects[i], content.meshes[i], content, context);
    if (!entry.ok()) return entry.error();
    map.objects.push_back(std::move(entry).value());
  }
  return Rounded(std::move(map));
}

// The scene as files: itself, without Draco (empty where nobody wants it), and its objects alone.
struct SceneFiles {
  Result<std::string> scene = std::string();
  Result<std::string> uncompressed = std::string();
  Result<std::string> objects = std::string();
};

SceneFiles EncodeScene(const gltf::GltfScene& scene, const Config& config) {
  std::vector<gltf::GlbKind> kinds = {{config.gltf.draco, false}, {config.gltf.draco, true}};
  if (config.export_stage.uncompressed_twin) kinds.push_back({false, false});
  std::vector<Result<std::string>> made = gltf::WriteGlbs(scene, config.gltf, kinds);
  SceneFiles files;
  files.scene = std::move(made[0]);
  files.objects = std::move(made[1]);
  if (made.size() > 2) files.uncompressed = std::move(made[2]);
  return files;
}

Status WriteOnRequest(StageContext& context,
                      const gltf::GltfScene& scene,
                      const SceneFiles& files,
                      const RunInputs& inputs) {
  const ExportStageOptions& wanted = inputs.config.export_stage;
  if (wanted.uncompressed_twin) {
    if (Status status = WriteEncoded(context, "scene.uncompressed.glb", files.uncompressed);
        !status.ok()) {
      return status;
    }
  }
  if (wanted.labelled_ply) {
    if (Status status = WriteEncoded(context, "scene.ply", EncodeLabelledPly(scene)); !status.ok())
      return status;
  }
  if (!wanted.habitat) return Ok();
  const Result<HabitatPair> pair = EncodeHabitatPair(scene);
  if (!pair.ok()) return pair.error();
  const Status status = context.Write("scene.semantic.glb", pair->glb);
  return status.ok() ? context.Write("scene.semantic.txt", pair->txt) : status;
}

}  // namespace

Result<StageSummary> RunExport(StageContext& context, const RunInputs& inputs) {
  const Result<Content> content = ReadContent(context);
  if (!content.ok()) return content.error();
  const gltf::GltfScene scene = MakeScene(*content, inputs);
  SceneFiles files;
  Result<CompactMap> map = CompactMap();
  std::vector<double> volumes_m3;
  const std::array<std::function<void()>, 2> encoders = {
      [&] { files = EncodeScene(scene, inputs.config); },
      [&] {
        map = MakeMap(context, *content, scene, inputs);
        for (const TriangleMesh& mesh : content->meshes)
          volumes_m3.push_back(mesh::CheckMesh(mesh).volume_m3);
      }};
  ParallelFor(encoders.size(), [&](std::size_t n) { encoders[n](); });
  if (Status status = WriteEncoded(context, "scene.glb", files.scene); !status.ok())
    return status.error();
  if (Status status = WriteOnRequest(context, scene, files, inputs); !status.ok())
    return status.error();
  if (!files.objects.ok()) return files.objects.error();
  if (!map.ok()) return map.error();
  const Result<std::string> map_json = artifact::EncodeMap(*map, "map.json");
  if (Status status = WriteEncoded(context, "map.json", map_json); !status.ok())
    return status.error();
  if (Status status =
          context.Write("objects.csv", artifact::EncodeObjectsCsv(map->objects, volumes_m3));
      !status.ok()) {
    return status.error();
  }
  return StageSummary{
      fmt::format("{} objects, scene {} bytes (objects {}), map {} bytes, verdict {}",
                  map->objects.size(),
                  files.scene->size(),
                  files.objects->size(),
                  map_json->size(),
                  NameOf(map->verdict)),
      {{"num_objects", static_cast<double>(map->objects.size())},
       {"scene_bytes", static_cast<double>(files.scene->size())},
       {"objects_glb_bytes", static_cast<double>(files.objects->size())},
       {"map_bytes", static_cast<double>(map_json->size())}}};
}

}  // namespace deepslam::stages
