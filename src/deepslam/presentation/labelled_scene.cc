#include "deepslam/presentation/labelled_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/mesh/floor_surface.h"
#include "deepslam/presentation/layout_parts.h"
#include "deepslam/presentation/map_rounding.h"
#include "deepslam/presentation/room_beside.h"

namespace deepslam::presentation {
namespace {

// The seen floor: room points near the ground plane.
std::optional<TriangleMesh> GroundMesh(const FinishedMap& finished,
                                       const mesh::GroundPolygonOptions& options) {
  if (!finished.map.has_ground) return std::nullopt;
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3f& vertex : finished.room_world.vertices) {
    if (std::abs(vertex.z()) < kRoomFloorBandM) points.emplace_back(vertex.x(), vertex.y());
  }
  const Result<TriangleMesh> polygon = mesh::GroundPolygon(points);
  if (!polygon.ok()) return std::nullopt;  // floor never seen: the scene goes without
  return mesh::ColouredGround(
      RoundedGround(*polygon), finished.room_world, kRoomFloorBandM, options.colour_step_m);
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
                        Rgb8 class_colour,
                        bool measured_colours) {
  gltf::GltfObject out;
  out.name = ObjectName(object);
  out.class_name = object.class_name;
  out.instance = object.id.value;
  out.score = object.confidence;
  out.source = NameOf(object.source);
  for (const ViewRegistration& view : object.views) out.views.push_back(view.frame.value);
  out.mesh = mesh;
  out.world_from_object = object.world_from_object;
  out.class_colour = class_colour;
  if (!measured_colours || IsPlain(mesh, out.class_colour)) out.mesh.colours.clear();
  out.credit = object.credit;
  out.model = object.model;
  out.scale_m = object.scale_m;
  return out;
}

void AddPath(const OptimizedMap& map, gltf::GltfScene& scene) {
  for (const TrackedFrame& frame : map.frames)
    scene.trajectory_world_from_camera.push_back(frame.world_from_camera);
  for (const FrameIdx keyframe : map.keyframes) {
    scene.keyframes.push_back(
        {keyframe.value, map.frames[static_cast<std::size_t>(keyframe.value)].world_from_camera});
  }
}

void AddSurroundings(const FinishedMap& finished,
                     const SceneOptions& options,
                     gltf::GltfScene& scene) {
  if (options.surroundings != Surroundings::kMeasured)
    scene.parts = LayoutParts(finished.layout_world, finished.room_world);
  const bool wanted = options.surroundings != Surroundings::kLayout || scene.parts.empty();
  if (!options.room || !wanted || finished.room_world.empty()) return;
  std::vector<TriangleMesh> parts_world;
  for (const gltf::GltfPart& part : scene.parts) parts_world.push_back(part.mesh_world);
  scene.room = RoomBeside(
      finished.room_world, finished.map.map.objects, finished.meshes, scene.ground, parts_world);
}

}  // namespace

gltf::GltfScene MakeScene(const FinishedMap& finished,
                          const ClassTable& classes,
                          const PinholeCamera& camera,
                          const RunIdentity& run,
                          const SceneOptions& options) {
  const std::vector<MapObject>& objects = finished.map.map.objects;
  gltf::GltfScene scene;
  for (std::size_t i = 0; i < finished.meshes.size(); ++i) {
    scene.objects.push_back(ToGltf(objects[i],
                                   finished.meshes[i],
                                   ClassColour(classes, objects[i].class_name),
                                   options.measured_colours));
  }
  scene.ground = GroundMesh(finished, options.ground_polygon);
  AddSurroundings(finished, options, scene);
  if (options.trajectory) AddPath(finished.map, scene);
  scene.camera = camera;
  scene.generator = fmt::format("deepslam {}", run.tool_version);
  scene.provenance = {{"capture_sha256", run.capture_sha256},
                      {"deepslam_version", run.tool_version}};
  return scene;
}

}  // namespace deepslam::presentation
