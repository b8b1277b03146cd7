// Tracking of a capture, alone and with the refinement of its path as stage `track` does both,
// beside decoding its frames alone: what no tracker can do without. The capture is the folder that
// DEEPSLAM_BENCH_CAPTURE names. Real time; as many threads as the argument says.
//   DEEPSLAM_BENCH_CAPTURE=... deepslam_tracking_bench --benchmark_repetitions=5
#include <memory>
#include <string>
#include <utility>

#include <benchmark/benchmark.h>

#include "bench_capture.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/progress.h"
#include "deepslam/mapping/track_path.h"
#include "deepslam/scene/edge_store.h"
#include "deepslam/tracking/odometry.h"

namespace deepslam {
namespace {

// items_per_second: frames.
void Report(benchmark::State& state, int num_frames) {
  state.SetItemsProcessed(state.iterations() * num_frames);
}

void TrackFrames(benchmark::State& state) {
  const Result<dataset::Capture> capture = bench::OpenNamedCapture();
  if (!capture.ok()) return state.SkipWithError(capture.error().message.c_str());
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  SilentProgress progress;
  for (auto _ : state) {
    const Result<Odometry> odometry = tracking::EstimateOdometry(*capture->frames, {}, progress);
    if (!odometry.ok()) return state.SkipWithError(odometry.error().message.c_str());
    benchmark::DoNotOptimize(odometry->frames.size());
  }
  Report(state, capture->frames->num_frames());
}

void TrackAndRefine(benchmark::State& state) {
  const Result<dataset::Capture> capture = bench::OpenNamedCapture();
  if (!capture.ok()) return state.SkipWithError(capture.error().message.c_str());
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  SilentProgress progress;
  const auto in_memory = [] { return std::make_shared<MemoryEdgeStore>(); };
  for (auto _ : state) {
    const Result<mapping::TrackedPath> path =
        mapping::TrackPath(*capture->frames, {}, {}, in_memory, progress);
    if (!path.ok()) return state.SkipWithError(path.error().message.c_str());
    benchmark::DoNotOptimize(path->odometry.frames.size());
  }
  Report(state, capture->frames->num_frames());
}

BENCHMARK(bench::DecodeFrames)
    ->Name("DecodeFrames")
    ->Arg(1)
    ->Arg(2)
    ->ArgName("threads")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(TrackFrames)
    ->Arg(1)
    ->Arg(2)
    ->ArgName("threads")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(TrackAndRefine)
    ->Arg(1)
    ->Arg(2)
    ->ArgName("threads")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace deepslam
