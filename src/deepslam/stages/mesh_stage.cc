// mesh: the chosen shapes as closed, metric, coloured triangle meshes.
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/ply.h"
#include "deepslam/core/parallel.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/colour_objects.h"
#include "deepslam/mesh/object_mesh.h"
#include "deepslam/stages/object_sources.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

using Meshes = std::vector<Result<TriangleMesh>>;  // of each object of the map

Result<Meshes> MakeShapes(const StageContext& context,
                          const Config& config,
                          const std::vector<MapObject>& objects) {
  std::vector<VoxelGrid> grids;
  std::vector<double> scales_m;
  for (const MapObject& object : objects) {
    Result<VoxelGrid> grid = ReadModel(context, "loops", object.model);
    if (!grid.ok()) return grid.error();
    grids.push_back(std::move(grid).value());
    scales_m.push_back(object.scale_m);
  }
  return mesh::MakeObjectMeshes(grids, scales_m, {config.surface, config.refine}, [&] {
    return context.progress().StopRequested();
  });
}

Status ColourByViews(const StageContext& context,
                     const RunInputs& inputs,
                     mesh::ObjectColouring& colouring) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Association> association = ReadAssociation(context, "loops");
  if (!association.ok()) return association.error();
  const std::vector<ObjectTrack> tracks = colouring.TracksToColour(association->tracks);
  std::size_t done = 0;
  const auto colour_batch = [&](std::span<modelling::TrackViews> batch) {
    ParallelFor(batch.size(),
                [&](std::size_t i) { colouring.Colour(batch[i].track->id, batch[i].views); });
    context.progress().Report(done += batch.size(), tracks.size());
    return Ok();
  };
  const auto views =
      OpenViews(context, *inputs.capture->frames, inputs.classes, inputs.config.views);
  if (!views.ok()) return views.error();
  return views->ForBatches(
      {tracks, *trajectory, *ground}, observe::ViewContent::kColourAndDepth, colour_batch);
}

// A mesh as it is written, and what is wrong with it.
struct Checked {
  mesh::MeshCheck check;
  Result<std::string> text = std::string();
};

std::string FileOf(const MapObject& object) {
  return fmt::format("objects/{}.ply", ObjectName(object));
}

// One object without a surface keeps its place and labels; the others are none the worse for it.
std::vector<Checked> Check(const std::vector<MapObject>& objects, const Meshes& meshes) {
  std::vector<Checked> checked(meshes.size());
  ParallelFor(meshes.size(), [&](std::size_t n) {
    const TriangleMesh triangles = meshes[n].ok() ? *meshes[n] : TriangleMesh();
    checked[n] = {mesh::CheckMesh(triangles),
                  artifact::EncodePly({triangles, {}, {}}, FileOf(objects[n]))};
  });
  return checked;
}

Result<StageSummary> WriteMeshes(StageContext& context,
                                 const std::vector<MapObject>& objects,
                                 const Meshes& meshes) {
  const std::vector<Checked> checked = Check(objects, meshes);
  std::size_t num_faces = 0;
  std::size_t num_faulty = 0;
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const std::string file = FileOf(objects[n]);
    if (!meshes[n].ok())
      context.progress().Warn(fmt::format("{}: {}", file, meshes[n].error().message));
    if (const mesh::MeshCheck& check = checked[n].check; !check.ok()) {
      context.progress().Warn(fmt::format("{} is not closed: {}", file, check.fault));
      ++num_faulty;
    }
    num_faces += meshes[n].ok() ? meshes[n]->faces.size() : 0;
    if (Status status = WriteEncoded(context, file, checked[n].text); !status.ok())
      return status.error();
  }
  return StageSummary{
      fmt::format("{} meshes, {} faces, {} not closed", objects.size(), num_faces, num_faulty),
      {{"num_meshes", static_cast<double>(objects.size())},
       {"num_faces", static_cast<double>(num_faces)},
       {"num_not_closed", static_cast<double>(num_faulty)}}};
}

}  // namespace

Result<StageSummary> RunMesh(StageContext& context, const RunInputs& inputs) {
  const Result<OptimizedMap> map = ReadOptimized(context);
  if (!map.ok()) return map.error();
  const std::vector<MapObject>& objects = map->map.objects;
  Result<Meshes> meshes = MakeShapes(context, inputs.config, objects);
  if (!meshes.ok()) return meshes.error();
  if (context.progress().StopRequested()) return Interrupted();
  mesh::ObjectColouring colouring(*map, inputs.classes, inputs.config.colour, *meshes);
  if (Status status = ColourByViews(context, inputs, colouring); !status.ok())
    return status.error();
  if (context.progress().StopRequested()) return Interrupted();
  colouring.ColourRest();
  return WriteMeshes(context, objects, *meshes);
}

}  // namespace deepslam::stages
