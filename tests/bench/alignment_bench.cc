// The kernels that tracking spends its time in beside decoding, one by one, on two frames of the
// capture that DEEPSLAM_BENCH_CAPTURE names, laid where tracking lays them. One thread.
//   DEEPSLAM_BENCH_CAPTURE=... deepslam_alignment_bench --benchmark_repetitions=5
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include <benchmark/benchmark.h>

#include "bench_capture.h"
#include "deepslam/alignment/alignment_system.h"
#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/place_score.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/alignment/rotation_search.h"
#include "deepslam/alignment/source_points.h"

namespace deepslam {
namespace {

// As far apart as a frame and its keyframe often are.
constexpr int kFramesBetween = 5;
constexpr int kFinestStride = 3;  // as tracking has it
constexpr int kCoarsestStride = 2;

struct TwoFrames {
  StoredDepth depth;             // of j
  IntensityImage intensity;      // of j, at the size of its finest level
  alignment::FramePyramid i, j;  // i is a reference
  Pose3 i_from_j;
  PinholeCamera camera;
};

Result<TwoFrames> ReadTwo() {
  const Result<dataset::Capture> capture = bench::OpenNamedCapture();
  if (!capture.ok()) return capture.error();
  const FrameSource& frames = *capture->frames;
  const int last = std::min(kFramesBetween, frames.num_frames() - 1);
  Result<alignment::ReadFrame> i = alignment::ReadPyramid(frames, FrameIdx{0}, {});
  if (!i.ok()) return i.error();
  Result<alignment::ReadFrame> j = alignment::ReadPyramid(frames, FrameIdx{last}, {});
  if (!j.ok()) return j.error();
  TwoFrames two{std::move(j->depth),
                j->pyramid.levels.front().intensity,
                alignment::AsReference(std::move(i->pyramid)),
                std::move(j->pyramid),
                Pose3{},
                frames.camera()};
  const std::array<Pose3, 1> starts = {Pose3{}};
  const alignment::FrameAlignment alignment = alignment::AlignPyramids(two.i, two.j, starts, {});
  if (!alignment.ok) return InvalidInput("the capture's first frames do not align");
  two.i_from_j = alignment.i_from_j;
  return two;
}

// Calls `kernel` with the frames again and again.
template <typename Kernel>
void Repeat(benchmark::State& state, const Kernel& kernel) {
  const Result<TwoFrames> two = ReadTwo();
  if (!two.ok()) return state.SkipWithError(two.error().message.c_str());
  for (auto _ : state) benchmark::DoNotOptimize(kernel(*two));
}

void BuildPyramid(benchmark::State& state) {
  Repeat(state, [](const TwoFrames& two) {
    return alignment::BuildPyramid(two.depth, two.intensity, two.camera, {}).valid_share;
  });
}
BENCHMARK(BuildPyramid)->Unit(benchmark::kMicrosecond);

// What a frame needs beside to become a keyframe, and a copy of it.
void AsReference(benchmark::State& state) {
  Repeat(state, [](const TwoFrames& two) { return alignment::AsReference(two.j).levels.size(); });
}
BENCHMARK(AsReference)->Unit(benchmark::kMicrosecond);

void SearchRotation(benchmark::State& state) {
  Repeat(state,
         [](const TwoFrames& two) { return alignment::SearchRotation(two.i, two.j).has_value(); });
}
BENCHMARK(SearchRotation)->Unit(benchmark::kMicrosecond);

alignment::SourcePoints FinestPoints(const alignment::FramePyramid& j) {
  return {j.levels.front(), {.stride = kFinestStride, .photometric = true, .near = true}};
}

void GatherSourcePoints(benchmark::State& state) {
  Repeat(state, [](const TwoFrames& two) { return FinestPoints(two.j).size(); });
}
BENCHMARK(GatherSourcePoints)->Unit(benchmark::kMicrosecond);

// A step's normal equations at the finest level, and what an end is scored by (cross: 1).
void BuildAlignmentSystem(benchmark::State& state) {
  const Result<TwoFrames> two = ReadTwo();
  if (!two.ok()) return state.SkipWithError(two.error().message.c_str());
  const alignment::SourcePoints points = FinestPoints(two->j);
  alignment::AlignmentGates gates;
  gates.cross_frames = state.range(0) != 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        alignment::BuildAlignmentSystem(two->i.levels.front(), points, two->i_from_j, gates, {})
            .num_matched);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points.size()));
}
BENCHMARK(BuildAlignmentSystem)->ArgName("cross")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

// One of the places that compete, at the coarsest level that is aligned.
void ScorePlace(benchmark::State& state) {
  const Result<TwoFrames> two = ReadTwo();
  if (!two.ok()) return state.SkipWithError(two.error().message.c_str());
  const std::size_t coarsest = alignment::NumAlignmentLevels(two->i) - 1;
  const alignment::SourcePoints points(
      two->j.levels[coarsest], {.stride = kCoarsestStride, .photometric = true, .near = false});
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        alignment::ScorePlace(two->i.levels[coarsest], points, two->i_from_j, {}, {}).support);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points.size()));
}
BENCHMARK(ScorePlace)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace deepslam
