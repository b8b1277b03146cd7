// What the refinement of one object costs: carving by its views, and moving the latents of a
// shipped decoder (configs/priors/chair) with its derivative.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <memory>

#include "deepslam/core/parallel.h"
#include "deepslam/propose/shape_prior.h"
#include "deepslam/refine/refine_latents.h"
#include "deepslam/storage/store.h"
#include "support/furniture_world.h"

namespace deepslam {
namespace {

using testing_support::ChairGrid;
using testing_support::FurnitureWorld;
using testing_support::ViewsAround;

std::vector<refine::PlacedView> Placed(const FurnitureWorld& world,
                                       const std::vector<ObjectView>& views) {
  std::vector<refine::PlacedView> placed;
  for (const ObjectView& view : views)
    placed.push_back({&view, view.world_from_camera.Inverse() * world.world_from_object()});
  return placed;
}

Result<std::unique_ptr<propose::ShapePrior>> LoadChair() {
  const std::filesystem::path folder =
      std::filesystem::path(DEEPSLAM_SOURCE_DIR) / "configs" / "priors" / "chair";
  const Result<std::string> sketch = storage::ReadFile(folder / "sketch.onnx");
  const Result<std::string> encoder = storage::ReadFile(folder / "encoder.onnx");
  const Result<std::string> decoder = storage::ReadFile(folder / "decoder.onnx");
  for (const Result<std::string>* bytes : {&sketch, &encoder, &decoder}) {
    if (!bytes->ok()) return bytes->error();
  }
  return propose::ShapePrior::Load("chair", *sketch, *encoder, *decoder);
}

void Carve(benchmark::State& state) {
  const FurnitureWorld world(ChairGrid(), 0.9);
  const std::vector<ObjectView> views = ViewsAround(world, static_cast<int>(state.range(0)));
  const std::vector<refine::PlacedView> placed = Placed(world, views);
  for (auto _ : state) benchmark::DoNotOptimize(refine::CarveEvidence(placed));
}
BENCHMARK(Carve)->ArgName("views")->Arg(8)->Arg(24)->Unit(benchmark::kMillisecond)->UseRealTime();

// Both starts of an object at once, as stage `select` does it.
void RefineTwoStarts(benchmark::State& state) {
  const Result<std::unique_ptr<propose::ShapePrior>> prior = LoadChair();
  if (!prior.ok()) return state.SkipWithError(prior.error().message.c_str());
  const FurnitureWorld world(ChairGrid(), 0.9);
  const std::vector<ObjectView> views = ViewsAround(world, 24);
  const std::vector<refine::Evidence> evidence = refine::CarveEvidence(Placed(world, views));
  const refine::Decoder decoder = {
      [&](std::span<const float> latents) { return (*prior)->Logits(latents); },
      [&](std::span<const float> latents, std::span<const float> by_logits) {
        return (*prior)->LatentGradient(latents, by_logits);
      }};
  for (auto _ : state) {
    ParallelFor(2, [&](std::size_t n) {
      const std::vector<float> start(propose::kNumLatents, n == 0 ? 0.5F : -0.5F);
      benchmark::DoNotOptimize(refine::RefineLatents(start, evidence, decoder, {}));
    });
  }
}
BENCHMARK(RefineTwoStarts)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace deepslam
