// The capture that benchmarks work on, the folder that DEEPSLAM_BENCH_CAPTURE names, and what it
// takes to decode it.
#pragma once

#include <atomic>
#include <cstdlib>
#include <string>

#include <benchmark/benchmark.h>

#include "deepslam/core/freed_memory.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/result.h"
#include "deepslam/layouts/open_capture.h"

namespace deepslam::bench {

inline Result<dataset::Capture> OpenNamedCapture() {
  // Once, before there are threads, as the program does: fresh pages would make decoding slower.
  [[maybe_unused]] static const bool keeps = (KeepFreedMemory(), true);
  const char* const folder =
      std::getenv("DEEPSLAM_BENCH_CAPTURE");  // NOLINT(concurrency-mt-unsafe)
  if (folder == nullptr)
    return InvalidConfig("DEEPSLAM_BENCH_CAPTURE: not set; name the folder of a capture");
  return layouts::OpenCapture(folder);
}

// All frames once, by the number of threads that the benchmark's argument gives.
inline void DecodeFrames(benchmark::State& state) {
  const Result<dataset::Capture> capture = OpenNamedCapture();
  if (!capture.ok()) return state.SkipWithError(capture.error().message.c_str());
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  const FrameSource& frames = *capture->frames;
  for (auto _ : state) {
    std::atomic<std::size_t> num_read = 0;
    ParallelFor(static_cast<std::size_t>(frames.num_frames()), [&](std::size_t n) {
      if (frames.Read(FrameIdx{static_cast<std::int32_t>(n)}).ok()) ++num_read;
    });
    benchmark::DoNotOptimize(num_read.load());
  }
  state.SetItemsProcessed(state.iterations() * frames.num_frames());
}

}  // namespace deepslam::bench
