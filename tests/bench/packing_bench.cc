// What a depth image that stays in memory costs, packed (dataset/packed_depth.h), beside decoding
// its file again. Frames of the capture that DEEPSLAM_BENCH_CAPTURE names, in turn; one thread.
//   DEEPSLAM_BENCH_CAPTURE=... deepslam_packing_bench --benchmark_repetitions=5
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench_capture.h"
#include "deepslam/dataset/packed_depth.h"

namespace deepslam {
namespace {

constexpr int kNumFrames = 10;

// Spread over the capture.
std::vector<FrameIdx> SomeFrames(const FrameSource& frames) {
  const int count = std::min(kNumFrames, frames.num_frames());
  std::vector<FrameIdx> some;
  for (int n = 0; n < count; ++n) some.push_back(FrameIdx{n * (frames.num_frames() / count)});
  return some;
}

void DecodeDepth(benchmark::State& state) {
  const Result<dataset::Capture> capture = bench::OpenNamedCapture();
  if (!capture.ok()) return state.SkipWithError(capture.error().message.c_str());
  const std::vector<FrameIdx> frames = SomeFrames(*capture->frames);
  std::size_t n = 0;
  for (auto _ : state) {
    const Result<Frame> frame = capture->frames->ReadDepth(frames[n++ % frames.size()]);
    if (!frame.ok()) return state.SkipWithError(frame.error().message.c_str());
    benchmark::DoNotOptimize(frame->depth_m.data());
  }
}
BENCHMARK(DecodeDepth)->Unit(benchmark::kMicrosecond);

// Calls `work` with each image and what it was packed to. Counts how small it got.
template <typename Work>
void ForImages(benchmark::State& state, const Work& work) {
  const Result<dataset::Capture> capture = bench::OpenNamedCapture();
  if (!capture.ok()) return state.SkipWithError(capture.error().message.c_str());
  const MetresOfRaw metres(capture->stored->cameras().depth_units_per_m);
  std::vector<DepthImage> images;
  std::vector<dataset::PackedDepth> packed;
  std::size_t num_bytes = 0, num_packed = 0;
  for (const FrameIdx idx : SomeFrames(*capture->frames)) {
    Result<Frame> frame = capture->frames->ReadDepth(idx);
    if (!frame.ok()) return state.SkipWithError(frame.error().message.c_str());
    packed.emplace_back(frame->depth_m, metres);
    num_bytes += sizeof(float) * frame->depth_m.size();
    num_packed += packed.back().num_bytes();
    images.push_back(std::move(frame->depth_m));
  }
  std::size_t n = 0;
  for (auto _ : state) {
    work(images[n], packed[n], metres);
    n = (n + 1) % images.size();
  }
  state.counters["of_its_bytes"] = static_cast<double>(num_packed) / static_cast<double>(num_bytes);
}

void PackDepth(benchmark::State& state) {
  ForImages(state, [](const DepthImage& depth_m, const auto&, const auto& metres) {
    benchmark::DoNotOptimize(dataset::PackedDepth(depth_m, metres).num_bytes());
  });
}
BENCHMARK(PackDepth)->Unit(benchmark::kMicrosecond);

void UnpackDepth(benchmark::State& state) {
  ForImages(state, [](const DepthImage&, const dataset::PackedDepth& packed, const auto&) {
    benchmark::DoNotOptimize(packed.Unpacked().data());
  });
}
BENCHMARK(UnpackDepth)->Unit(benchmark::kMicrosecond);

// What keeping it as it is would take.
void CopyDepth(benchmark::State& state) {
  ForImages(state, [](const DepthImage& depth_m, const auto&, const auto&) {
    benchmark::DoNotOptimize(DepthImage(depth_m).data());
  });
}
BENCHMARK(CopyDepth)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace deepslam
