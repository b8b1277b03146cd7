// mesh: the chosen shapes as closed, metric, coloured triangle meshes.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/ply.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/parallel_in_order.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/colour_mesh.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/stages/object_mesh.h"
#include "deepslam/stages/object_sources.h"
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

// Views with the optimized cameras in place of the tracked ones.
void UseOptimizedPoses(const OptimizedMap& map, std::span<ObjectView> views) {
  for (ObjectView& view : views) {
    view.world_from_camera =
        map.frames[static_cast<std::size_t>(view.frame.value)].world_from_camera;
  }
}

// Faces between what is occupied and what is not, which most of a mesh's time goes with.
std::size_t NumBoundaryFaces(const VoxelGrid& grid) {
  constexpr std::array<std::size_t, 3> kSteps = {
      1, std::size_t{kGridSize}, std::size_t{kGridSize} * kGridSize};
  const std::vector<std::uint8_t>& occupied = grid.occupied;
  std::size_t count = 0;
  for (const std::size_t step : kSteps) {
    for (std::size_t n = step; n < occupied.size(); ++n)
      count += occupied[n] != occupied[n - step] ? 1 : 0;
  }
  return count;
}

// Indices of the objects, that of the largest surface first: nothing large is left for the end.
std::vector<std::size_t> LargestFirst(const std::vector<VoxelGrid>& grids) {
  std::vector<std::size_t> num_faces;
  for (const VoxelGrid& grid : grids) num_faces.push_back(NumBoundaryFaces(grid));
  std::vector<std::size_t> order(grids.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t n) { return num_faces[n]; });
  return order;
}

using Meshes = std::vector<Result<TriangleMesh>>;  // of each object of the map

Meshes MakeShapes(const StageContext& context,
                  const RunInputs& inputs,
                  const std::vector<MapObject>& objects,
                  const std::vector<VoxelGrid>& grids) {
  Meshes shapes(objects.size(), Interrupted());
  const std::vector<std::size_t> order = LargestFirst(grids);
  ParallelInOrder(objects.size(), [&](std::size_t i) {
    const std::size_t n = order[i];
    if (context.progress().StopRequested()) return;
    shapes[n] =
        MakeObjectMesh(grids[n], objects[n].scale_m, inputs.config.surface, inputs.config.refine);
  });
  return shapes;
}

// The meshes in the colours that these views saw; what none saw has its class's.
void Colour(const MapObject& object,
            std::span<const ObjectView> views,
            const RunInputs& inputs,
            Result<TriangleMesh>& shape) {
  if (!shape.ok()) return;
  shape = mesh::ColourMesh(*shape,
                           views,
                           object.world_from_object,
                           ClassColour(inputs.classes, object.class_name),
                           inputs.config.colour);
}

Status ColourAll(const StageContext& context,
                 const RunInputs& inputs,
                 const Trajectory& trajectory,
                 const Ground& ground,
                 const Association& association,
                 const OptimizedMap& map,
                 Meshes& meshes) {
  const std::vector<MapObject>& objects = map.map.objects;
  std::map<ObjectId, std::size_t> index_of;
  for (std::size_t n = 0; n < objects.size(); ++n) index_of.emplace(objects[n].id, n);
  std::vector<ObjectTrack> tracks;
  std::copy_if(association.tracks.begin(),
               association.tracks.end(),
               std::back_inserter(tracks),
               [&](const ObjectTrack& track) { return index_of.contains(track.id); });
  std::vector<std::uint8_t> is_coloured(objects.size(), 0);
  std::size_t done = 0;
  const auto colour_batch = [&](std::span<modelling::TrackViews> batch) {
    ParallelFor(batch.size(), [&](std::size_t i) {
      const std::size_t n = index_of.at(batch[i].track->id);
      UseOptimizedPoses(map, batch[i].views);
      Colour(objects[n], batch[i].views, inputs, meshes[n]);
      is_coloured[n] = 1;
    });
    context.progress().Report(done += batch.size(), tracks.size());
    return Ok();
  };
  const auto views = OpenViews(context, *inputs.capture->frames, inputs.config.views);
  if (!views.ok()) return views.error();
  const Status status = views->ForBatches(
      {tracks, trajectory, ground}, observe::ViewContent::kColourAndDepth, colour_batch);
  for (std::size_t n = 0; n < objects.size(); ++n) {
    if (is_coloured[n] == 0) Colour(objects[n], {}, inputs, meshes[n]);
  }
  return status;
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

}  // namespace

Result<StageSummary> RunMesh(StageContext& context, const RunInputs& inputs) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Association> association = ReadAssociation(context, "loops");
  if (!association.ok()) return association.error();
  const Result<OptimizedMap> map = ReadOptimized(context);
  if (!map.ok()) return map.error();

  const std::vector<MapObject>& objects = map->map.objects;
  std::vector<VoxelGrid> grids;
  for (const MapObject& object : objects) {
    Result<VoxelGrid> grid = ReadModel(context, "loops", object.model);
    if (!grid.ok()) return grid.error();
    grids.push_back(std::move(grid).value());
  }
  Meshes meshes = MakeShapes(context, inputs, objects, grids);
  if (context.progress().StopRequested()) return Interrupted();
  if (Status status = ColourAll(context, inputs, *trajectory, *ground, *association, *map, meshes);
      !status.ok()) {
    return status.error();
  }
  if (context.progress().StopRequested()) return Interrupted();
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

}  // namespace deepslam::stages
