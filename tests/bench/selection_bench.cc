// What it costs to register and score all candidates of one object, by numbers of candidates and of
// views: chairs of other proportions than the one seen.
#include <benchmark/benchmark.h>

#include "deepslam/core/parallel.h"
#include "deepslam/registration/register_shape.h"
#include "deepslam/select/select.h"
#include "support/furniture_world.h"

namespace deepslam {
namespace {

using testing_support::CandidateFor;
using testing_support::ChairGrid;
using testing_support::FurnitureWorld;
using testing_support::ViewsAround;

void RegisterAndSelect(benchmark::State& state) {
  const int num_candidates = static_cast<int>(state.range(0));
  const FurnitureWorld world(ChairGrid(), 0.9);
  const std::vector<ObjectView> views = ViewsAround(world, static_cast<int>(state.range(1)));
  std::vector<ShapeCandidate> candidates;
  std::vector<shape::ShapeModel> models;
  for (int n = 0; n < num_candidates; ++n) {
    candidates.push_back(CandidateFor(0.6, 1.3, 0.95, n));
    models.emplace_back(ChairGrid(0.35 + 0.01 * (n % 30), 0.15 + 0.01 * (n % 20)));
  }
  for (auto _ : state) {
    const auto measured = registration::PrepareForRegistration(views);
    const auto prepared = select::PrepareForScoring(views);
    std::vector<CandidateRegistration> registrations(candidates.size());
    std::vector<CandidateScore> scores(candidates.size());
    ParallelFor(candidates.size(), [&](std::size_t i) {
      registrations[i] =
          registration::RegisterCandidate(candidates[i], models[i], std::span(measured), {});
      scores[i] = select::ScoreCandidate(
          candidates[i], models[i], registrations[i], std::span(prepared), {});
    });
    const MapObject object =
        select::SelectShape(ObjectId{0}, "chair", candidates, registrations, scores, views, {});
    if (!object.chosen.valid()) state.SkipWithError("nothing was selected");
  }
}
BENCHMARK(RegisterAndSelect)
    ->ArgNames({"candidates", "views"})
    ->Args({10, 10})
    ->Args({30, 10})
    ->Args({10, 30})
    ->Args({30, 30})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace deepslam
