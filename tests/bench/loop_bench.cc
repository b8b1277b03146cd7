// Finding keyframes that look alike, by their number: corners that come into view and leave it
// again along a way that does not come back, so that every list of candidates is sought in vain.
#include <benchmark/benchmark.h>

#include "deepslam/core/random.h"
#include "deepslam/loop/similar_keyframes.h"

namespace deepslam::loop {
namespace {

constexpr int kInView = 500;
constexpr int kNewPerKeyframe = 100;
constexpr int kFlippedBits = 25;  // of 256, between two views of one corner

std::vector<KeyframeFeatures> Walk(int num_keyframes) {
  std::vector<KeyframeFeatures> features(static_cast<std::size_t>(num_keyframes));
  for (int k = 0; k < num_keyframes; ++k) {
    KeyframeFeatures& keyframe = features[static_cast<std::size_t>(k)];
    keyframe.keyframe = FrameIdx{k};
    Random noise(1, "view", static_cast<std::uint64_t>(k));
    for (int n = 0; n < kInView; ++n) {
      Random corner(1, "corner", static_cast<std::uint64_t>(k * kNewPerKeyframe + n));
      BinaryDescriptor descriptor{corner.Next(), corner.Next(), corner.Next(), corner.Next()};
      for (int bit = 0; bit < kFlippedBits; ++bit) {
        const std::uint64_t flipped = noise.Index(256);
        descriptor[flipped / 64] ^= std::uint64_t{1} << (flipped % 64);
      }
      keyframe.descriptors.push_back(descriptor);
      keyframe.points_camera.emplace_back(0, 0, 1);
    }
  }
  return features;
}

void SimilarKeyframes(benchmark::State& state) {
  const std::vector<KeyframeFeatures> features = Walk(static_cast<int>(state.range(0)));
  std::size_t candidates = 0;
  for (auto _ : state) {
    candidates = 0;
    for (const auto& list : FindSimilarKeyframes(features, {})) candidates += list.size();
  }
  state.counters["candidates"] = static_cast<double>(candidates);
}
BENCHMARK(SimilarKeyframes)->Arg(1000)->Arg(3000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace deepslam::loop
