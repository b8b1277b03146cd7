// What no run can do without: decoding its frames, the forward passes of its networks, and bringing
// its frames through memory once. whole_run.py holds the stages' times against these.
//   DEEPSLAM_BENCH_CAPTURE=... deepslam_floor_bench --benchmark_repetitions=5
// Real time; as many threads as the argument says; items_per_second is frames per second.
#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench_capture.h"
#include "deepslam/core/parallel.h"
#include "deepslam/detect/detector.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/model_cache.h"

namespace deepslam {
namespace {

constexpr int kDetectorImages = 24;

// The default detector on frames spread over the capture, as stage `detect` calls it: images side
// by side, one thread in each forward pass.
void Passes(benchmark::State& state, bool fitted) {
  const Result<dataset::Capture> capture = bench::OpenNamedCapture();
  if (!capture.ok()) return state.SkipWithError(capture.error().message.c_str());
  const Result<std::filesystem::path> weights =
      stages::FindWeights(stages::FindDataFolder(""), "yolov8s");
  if (!weights.ok()) return state.SkipWithError(weights.error().message.c_str());
  const FrameSource& frames = *capture->frames;
  detect::DetectorOptions options;
  if (fitted) options.images = {frames.camera().width, frames.camera().height};
  const auto detector = stages::LoadDetectorFile(*weights, options);
  if (!detector.ok()) return state.SkipWithError(detector.error().message.c_str());
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  std::vector<ColourImage> images;
  const int num_images = std::min(kDetectorImages, frames.num_frames());
  for (int n = 0; n < num_images; ++n) {
    Result<Frame> frame = frames.ReadColour(FrameIdx{n * frames.num_frames() / num_images});
    if (frame.ok()) images.push_back(std::move(frame->colour));
  }
  for (auto _ : state) {
    ParallelFor(images.size(), [&](std::size_t n) {
      benchmark::DoNotOptimize((*detector)->Detect(images[n]).ok());
    });
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(images.size()));
}

// With an input as large as the images, as a run has it.
void DetectorPasses(benchmark::State& state) { Passes(state, true); }
// With the input of the detector's file, a square, and padding in a part of it.
void PaddedPasses(benchmark::State& state) { Passes(state, false); }

// A decoded frame copied: depth and colour read once and written once.
void CopyFrames(benchmark::State& state) {
  const Result<dataset::Capture> capture = bench::OpenNamedCapture();
  if (!capture.ok()) return state.SkipWithError(capture.error().message.c_str());
  const PinholeCamera& camera = capture->frames->camera();
  const std::size_t num_bytes = static_cast<std::size_t>(camera.width) *
                                static_cast<std::size_t>(camera.height) *
                                (sizeof(float) + sizeof(Rgb8));
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  constexpr std::size_t kFrames = 64;  // together more than the caches hold
  const std::vector<char> from(kFrames * num_bytes, 1);
  std::vector<char> to(kFrames * num_bytes, 0);
  for (auto _ : state) {
    ParallelFor(kFrames, [&](std::size_t n) {
      std::memcpy(to.data() + n * num_bytes, from.data() + n * num_bytes, num_bytes);
    });
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kFrames));
}

BENCHMARK(bench::DecodeFrames)
    ->Name("DecodeFrames")
    ->Arg(2)
    ->ArgName("threads")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(DetectorPasses)->Arg(2)->ArgName("threads")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(PaddedPasses)->Arg(2)->ArgName("threads")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(CopyFrames)->Arg(2)->ArgName("threads")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace deepslam
