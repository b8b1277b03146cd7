// mesh: the chosen shapes as closed, metric, coloured triangle meshes.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "deepslam/artifact/ply.h"
#include "deepslam/core/parallel.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/colour_mesh.h"
#include "deepslam/stages/object_mesh.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

Rgb8 ClassColour(const ClassTable& classes, const std::string& class_name) {
  const ObjectClass* object_class = classes.Find(class_name);
  if (object_class == nullptr) return {160, 160, 160};
  const auto channel = [&](std::size_t i) {
    return static_cast<std::uint8_t>(object_class->colour_rgb[i]);
  };
  return {channel(0), channel(1), channel(2)};
}

Result<TriangleMesh> MakeMesh(const MapObject& object,
                              const VoxelGrid& grid,
                              std::span<const ObjectView> views,
                              const RunInputs& inputs) {
  const Result<TriangleMesh> refined =
      MakeObjectMesh(grid, object.scale_m, inputs.config.surface, inputs.config.refine);
  if (!refined.ok()) return refined.error();
  return mesh::ColourMesh(*refined,
                          views,
                          object.world_from_object,
                          ClassColour(inputs.classes, object.class_name),
                          inputs.config.colour);
}

// Views with the optimized cameras in place of the tracked ones.
void UseOptimizedPoses(const OptimizedMap& map, std::span<ObjectView> views) {
  for (ObjectView& view : views) {
    view.world_from_camera =
        map.frames[static_cast<std::size_t>(view.frame.value)].world_from_camera;
  }
}

// Indices into the batch, the object of most voxels first: nothing large then is left for the end.
std::vector<std::size_t> LargestFirst(std::span<const TrackViews> batch,
                                      const std::map<ObjectId, VoxelGrid>& grids) {
  std::vector<std::ptrdiff_t> num_voxels;
  for (const TrackViews& of_track : batch) {
    const std::vector<std::uint8_t>& occupied = grids.at(of_track.track->id).occupied;
    num_voxels.push_back(std::count(occupied.begin(), occupied.end(), 1));
  }
  std::vector<std::size_t> order(batch.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t n) { return num_voxels[n]; });
  return order;
}

using Meshes = std::map<ObjectId, Result<TriangleMesh>>;

// Of the objects of these tracks; those of objects without a track are not there.
Result<Meshes> MakeMeshes(const StageContext& context,
                          const RunInputs& inputs,
                          const Odometry& odometry,
                          const Ground& ground,
                          const Association& association,
                          const OptimizedMap& map,
                          const std::map<ObjectId, VoxelGrid>& grids) {
  std::map<ObjectId, const MapObject*> objects;
  for (const MapObject& object : map.map.objects) objects.emplace(object.id, &object);
  std::vector<ObjectTrack> tracks;
  std::copy_if(association.tracks.begin(),
               association.tracks.end(),
               std::back_inserter(tracks),
               [&](const ObjectTrack& track) { return objects.contains(track.id); });
  Meshes meshes;
  std::size_t done = 0;
  const auto make_batch = [&](std::span<TrackViews> batch) {
    std::vector<std::optional<Result<TriangleMesh>>> made(batch.size());
    const std::vector<std::size_t> order = LargestFirst(batch, grids);
    ParallelFor(batch.size(), [&](std::size_t i) {
      const std::size_t n = order[i];
      const ObjectId id = batch[n].track->id;
      UseOptimizedPoses(map, batch[n].views);
      made[n] = MakeMesh(*objects.at(id), grids.at(id), batch[n].views, inputs);
    });
    for (std::size_t n = 0; n < batch.size(); ++n)
      meshes.emplace(batch[n].track->id, *std::move(made[n]));
    context.progress().Report(done += batch.size(), tracks.size());
    return Ok();
  };
  const Status status = ForTrackViews(
      context, inputs, odometry, ground, tracks, observe::ViewContent::kColourAndDepth, make_batch);
  if (!status.ok()) return status.error();
  return meshes;
}

}  // namespace

Result<StageSummary> RunMesh(StageContext& context, const RunInputs& inputs) {
  const Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Association> association = ReadAssociation(context, "loops");
  if (!association.ok()) return association.error();
  const Result<OptimizedMap> map = ReadOptimized(context);
  if (!map.ok()) return map.error();

  const std::vector<MapObject>& objects = map->map.objects;
  std::map<ObjectId, VoxelGrid> grids;
  for (const MapObject& object : objects) {
    Result<VoxelGrid> grid = ReadModel(context, "loops", object.model);
    if (!grid.ok()) return grid.error();
    grids.emplace(object.id, std::move(grid).value());
  }
  Result<Meshes> meshes =
      MakeMeshes(context, inputs, *odometry, *ground, *association, *map, grids);
  if (!meshes.ok()) return meshes.error();
  if (context.progress().StopRequested()) return Interrupted();
  std::size_t num_faces = 0;
  std::size_t num_faulty = 0;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::string file = fmt::format("objects/{}.ply", ObjectName(objects[i]));
    // One object without a surface keeps its place and labels; the others are none the worse for
    // it.
    const auto made = meshes->find(objects[i].id);
    const Result<TriangleMesh> made_now =
        made == meshes->end() ? MakeMesh(objects[i], grids.at(objects[i].id), {}, inputs)
                              : std::move(made->second);
    if (!made_now.ok())
      context.progress().Warn(fmt::format("{}: {}", file, made_now.error().message));
    const TriangleMesh triangles = made_now.ok() ? *made_now : TriangleMesh();
    if (const mesh::MeshCheck check = mesh::CheckMesh(triangles); !check.ok()) {
      context.progress().Warn(fmt::format("{} is not closed: {}", file, check.fault));
      ++num_faulty;
    }
    num_faces += triangles.faces.size();
    if (Status status = WriteEncoded(context, file, artifact::EncodePly({triangles, {}, {}}, file));
        !status.ok()) {
      return status.error();
    }
  }
  return StageSummary{
      fmt::format("{} meshes, {} faces, {} not closed", objects.size(), num_faces, num_faulty),
      {{"num_meshes", static_cast<double>(objects.size())},
       {"num_faces", static_cast<double>(num_faces)},
       {"num_not_closed", static_cast<double>(num_faulty)}}};
}

}  // namespace deepslam::stages
