// The graph's cost by its size: keyframes with odometry and skip edges and a view of the ground
// each, and a tenth as many objects, each seen in ten or more views; robust losses in rounds, as by
// default. And of a path that goes round and round, each keyframe registered to twelve before it
// and tied to two earlier rounds: solved by a factorisation, by conjugate gradients, and by those
// with fewer nodes. One thread does the work, whatever the machine has.
#include <benchmark/benchmark.h>

#include "graph/synthetic_graph.h"

namespace deepslam::graph {
namespace {

using testing_support::Disturbance;
using testing_support::Information;
using testing_support::MakeWorld;
using testing_support::Noise;
using testing_support::World;

constexpr Noise kNoise{0.004, 0.002, 0.02, 0.02};

World WorldOf(int num_keyframes, int num_objects) {
  // Each object in four keyframes of each lap.
  const double laps = num_keyframes / (4.0 * num_objects);
  World world = MakeWorld(num_keyframes, num_objects, laps, kNoise);
  Random random(2);
  for (int k = 2; k < num_keyframes; ++k) {
    const auto b = static_cast<std::size_t>(k);
    world.odometry.edges.push_back(
        {FrameIdx{k - 2},
         FrameIdx{k},
         world.world_from_camera[b - 2].Inverse() * world.world_from_camera[b] *
             Disturbance(random, kNoise.translation_m, kNoise.rotation_rad),
         Information(kNoise.translation_m, kNoise.rotation_rad),
         false});
  }
  return world;
}

void Optimise(benchmark::State& state) {
  const int num_keyframes = static_cast<int>(state.range(0));
  const World world = WorldOf(num_keyframes, num_keyframes / 10);
  for (auto _ : state) {
    const Result<OptimizedMap> map = OptimizeGraph(
        world.odometry, world.ground, world.map, world.loops, GraphOptions(), {world.feet, {}});
    if (!map.ok() || !map->summary.converged) state.SkipWithError("not converged");
    state.counters["iterations"] = map->summary.num_iterations;
    state.counters["error_m"] = testing_support::TrajectoryError(map->frames, world);
  }
}
BENCHMARK(Optimise)
    ->Arg(100)
    ->Arg(300)
    ->Arg(1000)
    ->Arg(3000)
    ->Arg(10000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

enum Way { kFactorisation, kGradients, kFewerNodes };

void OptimiseRounds(benchmark::State& state) {
  constexpr int kRound = 170;
  const int num_keyframes = static_cast<int>(state.range(0));
  World world = MakeWorld(num_keyframes, 1, num_keyframes / double{kRound}, kNoise);
  world.map.objects.clear();
  testing_support::AddMeasured(
      {kRound, {2, 5, 10, 15, 20, 25, 30, 35, 40, 50, 60}, true}, kNoise, 1, world);
  testing_support::RefineLocally(world);
  GraphOptions options;
  if (state.range(1) == kFactorisation) options.max_direct_keyframes = 1000000;
  if (state.range(1) != kFewerNodes) options.max_keyframes = 1000000;
  for (auto _ : state) {
    const Result<OptimizedMap> map =
        OptimizeGraph(world.odometry, world.ground, world.map, world.loops, options);
    if (!map.ok() || !map->summary.converged) state.SkipWithError("not converged");
    state.counters["iterations"] = map->summary.num_iterations;
    state.counters["error_m"] = testing_support::TrajectoryError(map->frames, world);
  }
}
BENCHMARK(OptimiseRounds)
    ->ArgNames({"keyframes", "way"})
    ->ArgsProduct({{250, 500, 750}, {kFactorisation, kGradients}})
    ->ArgsProduct({{2500, 10000}, {kGradients, kFewerNodes}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace deepslam::graph
