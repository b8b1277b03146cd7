// optimize: cameras, objects and ground brought into agreement, in the gravity-aligned world.
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/ground_json.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/summary_json.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/graph/object_graph.h"
#include "deepslam/mapping/measure_walls.h"
#include "deepslam/shape/shape_model.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// Walls as keyframes saw them along the path before loops, which the layout was found along.
Result<graph::WallViews> Walls(const StageContext& context,
                               const RunInputs& inputs,
                               const Trajectory& trajectory) {
  if (!inputs.config.optimize.use_walls) return graph::WallViews{};
  const Result<Layout> layout = ReadLayout(context);
  if (!layout.ok()) return layout.error();
  return mapping::MeasureWalls(
      *inputs.capture->frames, trajectory, *layout, mapping::WallViewOptions(), context.progress());
}

Result<std::map<ObjectId, graph::ObjectFoot>> Feet(const StageContext& context,
                                                   const ClassTable& classes,
                                                   const ObjectMap& map) {
  std::map<ObjectId, graph::ObjectFoot> feet;
  for (const MapObject& object : map.objects) {
    const Result<VoxelGrid> grid = ReadModel(context, "loops", object.model);
    if (!grid.ok()) return grid.error();
    feet[object.id] = {object.scale_m * shape::BottomOf(*grid),
                       classes.TraitsOf(object.class_name).supports};
  }
  return feet;
}

StageSummary Summarise(const OptimizedMap& map) {
  double before = 0;
  double after = 0;
  for (const EnergyTerm& term : map.summary.terms) {
    before += term.before;
    after += term.after;
  }
  return {fmt::format("{}, {} iterations, energy {:.4g} -> {:.4g}",
                      map.summary.converged ? "converged" : "not converged",
                      map.summary.num_iterations,
                      before,
                      after),
          {{"converged", map.summary.converged ? 1.0 : 0.0},
           {"energy_before", before},
           {"energy_after", after}}};
}

}  // namespace

Result<StageSummary> RunOptimize(StageContext& context, const RunInputs& inputs) {
  const Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<ObjectMap> map = ReadObjects(context, "loops");
  if (!map.ok()) return map.error();
  const Result<Loops> loops = ReadLoops(context);
  if (!loops.ok()) return loops.error();
  Result<std::map<ObjectId, graph::ObjectFoot>> feet = Feet(context, inputs.classes, *map);
  if (!feet.ok()) return feet.error();
  Result<graph::WallViews> walls = Walls(context, inputs, *odometry);
  if (!walls.ok()) return walls.error();
  const graph::GraphSurroundings surroundings{std::move(feet).value(), std::move(walls).value()};
  const graph::GraphOptions& options = inputs.config.optimize;
  const Result<OptimizedMap> optimized =
      graph::OptimizeGraph(*odometry, *ground, *map, *loops, options, surroundings);
  if (!optimized.ok()) return optimized.error();

  Ground final_ground{std::nullopt, ground->observations, {}, ground->upright};
  if (optimized->has_ground) final_ground.plane_world = optimized->ground_world;
  const artifact::OptimizationRecord record{
      optimized->summary, optimized->ground_world, optimized->has_ground};
  const auto trajectory = artifact::StampedPoses(optimized->frames);
  const auto keyframes = artifact::KeyframePoses(optimized->frames, optimized->keyframes);
  const Status written = WriteFiles(
      context,
      {{"trajectory.tum", [&] { return artifact::EncodeTum(trajectory, "trajectory.tum"); }},
       {"keyframes.tum", [&] { return artifact::EncodeTum(keyframes, "keyframes.tum"); }},
       {"frames.json",
        [&] {
          return artifact::EncodeFrames(
              optimized->frames, optimized->keyframes, JoinsOf(*odometry), "frames.json");
        }},
       {"graph_before.g2o",
        [&] { return graph::GraphToG2o(*odometry, *ground, *map, *loops, options, surroundings); }},
       {"graph.g2o",
        [&] {
          return graph::GraphToG2o(
              *odometry, *ground, *map, *loops, options, surroundings, &*optimized);
        }},
       {"objects.json", [&] { return artifact::EncodeObjectMap(optimized->map, "objects.json"); }},
       {"ground.json", [&] { return artifact::EncodeGround(final_ground, "ground.json"); }},
       {"summary.json", [&] { return artifact::EncodeOptimization(record, "summary.json"); }}});
  if (!written.ok()) return written.error();
  return Summarise(*optimized);
}

}  // namespace deepslam::stages
