#include "deepslam/modelling/refine_candidates.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/modelling/long_side.h"
#include "deepslam/modelling/measured_limits.h"
#include "deepslam/modelling/turned_along.h"
#include "deepslam/modelling/walls_behind.h"
#include "deepslam/refine/complete.h"
#include "deepslam/refine/refine_latents.h"
#include "deepslam/registration/register_shape.h"
#include "deepslam/scene/object_name.h"
#include "deepslam/select/select.h"

namespace deepslam::modelling {
namespace {

// As its latents give it: a shape that was stretched since has none.
bool IsOfNetwork(const ShapeCandidate& candidate) {
  return !candidate.latents.empty() && !TraitsOf(candidate.source).is_derived;
}

// Indices into the set: the best by score, and the mean latent where it is another.
std::vector<std::size_t> Starts(const CandidateSet& set) {
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < set.candidates.size(); ++i) {
    if (!IsOfNetwork(set.candidates[i]) || !set.registrations[i].ok) continue;
    if (starts.empty() || set.scores[i].score > set.scores[starts[0]].score) starts = {i};
  }
  if (starts.empty()) return starts;
  for (std::size_t i = 0; i < set.candidates.size(); ++i) {
    if (IsOfNetwork(set.candidates[i]) && !set.candidates[i].view.valid() &&
        set.registrations[i].ok && i != starts[0])
      starts.push_back(i);
  }
  return starts;
}

// Index of what would be selected.
std::optional<std::size_t> WinnerOf(const CandidateSet& set,
                                    std::span<const ObjectView> views,
                                    const select::SelectOptions& options) {
  const MapObject best = select::SelectShape(
      set.object, set.class_name, set.candidates, set.registrations, set.scores, views, options);
  const auto winner = std::ranges::find(set.candidates, best.chosen, &ShapeCandidate::id);
  if (winner == set.candidates.end()) return std::nullopt;
  return static_cast<std::size_t>(winner - set.candidates.begin());
}

// Index of the whole model that would be selected.
std::optional<std::size_t> ToComplete(const CandidateSet& set,
                                      std::span<const ObjectView> views,
                                      const select::SelectOptions& options) {
  std::vector<std::size_t> whole;
  std::vector<ShapeCandidate> candidates;
  std::vector<CandidateRegistration> registrations;
  std::vector<CandidateScore> scores;
  for (std::size_t i = 0; i < set.candidates.size(); ++i) {
    if (!TraitsOf(set.candidates[i].source).can_be_completed) continue;
    whole.push_back(i);
    candidates.push_back(set.candidates[i]);
    registrations.push_back(set.registrations[i]);
    scores.push_back(set.scores[i]);
  }
  const MapObject best = select::SelectShape(
      set.object, set.class_name, candidates, registrations, scores, views, options);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    if (candidates[n].id == best.chosen) return whole[n];
  }
  return std::nullopt;
}

// At most `count` of the views, evenly, with the grid at place(i) in view i.
template <typename Place>
std::vector<refine::PlacedView> PlacedViews(std::span<const ObjectView> views,
                                            std::size_t count,
                                            const Place& place) {
  std::vector<refine::PlacedView> placed;
  const std::size_t num_taken = std::min(count, views.size());
  for (std::size_t n = 0; n < num_taken; ++n) {
    const std::size_t i = n * views.size() / num_taken;
    placed.push_back({&views[i], place(i)});
  }
  return placed;
}

struct RefinedShape {
  std::vector<float> latents;
  VoxelGrid grid;
};

Result<RefinedShape> RefineShape(const ShapeCandidate& start,
                                 const CandidateRegistration& registration,
                                 std::span<const ObjectView> views,
                                 const propose::ShapePrior& prior,
                                 const ObjectOptions& options) {
  const refine::RefineOptions& refinement = options.refinement;
  const bool by_depth = options.use_depth;
  const Result<Similarity3> object_from_decoded = prior.ObjectFromDecoded(start.latents, by_depth);
  if (!object_from_decoded.ok()) return object_from_decoded.error();
  const auto place = [&](std::size_t i) {
    const Pose3 camera_from_object =
        CameraFromObject(registration, views[i].detection, i, views[i].world_from_camera);
    return Similarity3::From(camera_from_object, registration.scale_m) * *object_from_decoded;
  };
  const auto placed =
      PlacedViews(views, static_cast<std::size_t>(refine::RefineOptions::kMaxViews), place);
  const std::vector<refine::Evidence> evidence = refine::CarveEvidence(placed);
  const refine::Decoder decoder = {
      [&](std::span<const float> latents) { return prior.Logits(latents); },
      [&](std::span<const float> latents, std::span<const float> by_logits) {
        return prior.LatentGradient(latents, by_logits);
      }};
  Result<refine::RefinedLatents> latents =
      refine::RefineLatents(start.latents, evidence, decoder, refinement);
  if (!latents.ok()) return latents.error();
  const Result<std::vector<float>> logits = prior.Logits(latents->latents);
  if (!logits.ok()) return logits.error();
  Result<VoxelGrid> grid = prior.Solid(*logits, by_depth);
  if (!grid.ok()) return grid.error();
  return RefinedShape{std::move(latents->latents), std::move(grid).value()};
}

bool HasSupportPlane(const CandidateSet& set, const ObjectOptions& options) {
  return options.classes != nullptr && options.classes->TraitsOf(set.class_name).support_plane;
}

// Of the own measurement of a thing with a support plane, whose outline is seen on all sides; null
// without one.
const CandidateRegistration* MeasuredOutline(const CandidateSet& set,
                                             const ObjectOptions& options) {
  if (!HasSupportPlane(set, options)) return nullptr;
  for (std::size_t i = 0; i < set.candidates.size(); ++i) {
    if (TraitsOf(set.candidates[i].source).is_partial && set.registrations[i].ok)
      return &set.registrations[i];
  }
  return nullptr;
}

Similarity3 WorldFromObject(const CandidateRegistration& registration) {
  return Similarity3::From(registration.world_from_object, registration.scale_m);
}

// What `start` became where it stands, under a name that begins with `change`.
void Add(const ShapeCandidate& start,
         CandidateSource source,
         std::string_view change,
         const Similarity3& world_from_object,
         std::vector<float> latents,
         VoxelGrid grid,
         Proposals& proposals) {
  ShapeCandidate candidate = start;
  candidate.id = CandidateId();
  candidate.source = source;
  candidate.view = DetectionId();
  candidate.model = fmt::format("{}_{:03d}_{}", change, start.object.value, start.id.value);
  candidate.world_from_object = world_from_object;
  candidate.latents = std::move(latents);
  candidate.library_id.clear();
  candidate.stretch.setOnes();
  proposals.models.emplace(candidate.model, std::move(grid));
  proposals.candidates.push_back(std::move(candidate));
}

}  // namespace

Proposals RefineShapes(const CandidateSet& set,
                       std::span<const ObjectView> views,
                       const propose::ShapePrior& prior,
                       const ObjectOptions& options) {
  const std::vector<std::size_t> starts = Starts(set);
  std::vector<std::optional<Result<RefinedShape>>> shapes(starts.size());
  ParallelFor(starts.size(), [&](std::size_t n) {
    const ShapeCandidate& start = set.candidates[starts[n]];
    shapes[n] = RefineShape(start, set.registrations[starts[n]], views, prior, options);
  });
  Proposals refined;
  for (std::size_t n = 0; n < starts.size(); ++n) {
    const ShapeCandidate& start = set.candidates[starts[n]];
    if (!shapes[n]->ok()) {
      refined.notes.push_back(fmt::format("{}: candidate {} cannot be refined: {}",
                                          ObjectName(set.class_name, set.object),
                                          start.id.value,
                                          shapes[n]->error().message));
      continue;
    }
    RefinedShape shape = std::move(*shapes[n]).value();
    Add(start,
        CandidateSource::kRefined,
        "refined",
        WorldFromObject(set.registrations[starts[n]]),
        std::move(shape.latents),
        std::move(shape.grid),
        refined);
  }
  return refined;
}

Proposals CompleteBest(const CandidateSet& set,
                       std::span<const ObjectView> views,
                       std::string_view change,
                       const ObjectOptions& options) {
  Proposals completed;
  const std::optional<std::size_t> best = ToComplete(set, views, options.select);
  if (!best) return completed;
  const ShapeCandidate& start = set.candidates[*best];
  CandidateRegistration registration = set.registrations[*best];
  if (const CandidateRegistration* measured = MeasuredOutline(set, options)) {
    registration.world_from_object =
        TurnedAlong(registration.world_from_object, measured->world_from_object);
  }
  // At the joint pose: a view's own follows the model that is to be corrected.
  const auto place = [&](std::size_t i) {
    return Similarity3::From(views[i].world_from_camera.Inverse() * registration.world_from_object,
                             registration.scale_m);
  };
  const auto placed =
      PlacedViews(views, static_cast<std::size_t>(refine::RefineOptions::kMaxViews), place);
  const shape::ShapeModel& whole = *set.models.at(start.model);
  refine::Limits limits =
      MeasuredLimits(WorldFromObject(registration), views, HasSupportPlane(set, options));
  if (options.layout != nullptr) {
    limits.walls = WallsBehind(*options.layout, whole, WorldFromObject(registration), views);
  }
  std::optional<refine::CompletedModel> model =
      refine::CompleteModel(whole, placed, options.refinement, limits);
  if (!model) return completed;
  if (HasSupportPlane(set, options)) FaceAcrossLongSide(*model);
  const Similarity3 world_from_completed = WorldFromObject(registration) * model->model_from_grid;
  Add(start,
      CandidateSource::kCompleted,
      change,
      world_from_completed,
      {},
      std::move(model->grid),
      completed);
  ShapeCandidate& candidate = completed.candidates.back();
  candidate.size_m = world_from_completed.scale * kModelExtent;
  // Its size was measured, whatever its class and its design say.
  candidate.min_size_m = std::min(candidate.min_size_m, candidate.size_m);
  candidate.max_size_m = std::max(candidate.max_size_m, candidate.size_m);
  return completed;
}

std::optional<std::size_t> RefineWinner(std::span<const ObjectView> views,
                                        const ObjectOptions& options,
                                        CandidateSet& set) {
  if (!options.refinement.pose) return std::nullopt;
  const std::optional<std::size_t> winner = WinnerOf(set, views, options.select);
  if (!winner) return std::nullopt;
  const ShapeCandidate& candidate = set.candidates[*winner];
  const shape::ShapeModel& model = *set.models.at(candidate.model);
  CandidateRegistration& registration = set.registrations[*winner];
  CandidateScore& score = set.scores[*winner];
  CandidateRegistration other_registration =
      registration::RegisterCandidateNear(candidate,
                                          model,
                                          WorldFromObject(registration),
                                          registration::PrepareForRegistration(views),
                                          options.registration);
  CandidateScore other_score = select::ScoreCandidate(candidate,
                                                      model,
                                                      other_registration,
                                                      std::span(std::as_const(set.scored_views)),
                                                      options.select);
  other_score.front_blocked = score.front_blocked;  // it stands where it stood but for centimetres
  if (!other_registration.ok || other_score.score <= score.score) return std::nullopt;
  std::swap(registration, other_registration);
  std::swap(score, other_score);
  if (WinnerOf(set, views, options.select) == winner) return winner;
  // Fewer views hold it there, or it turns its back: something that agrees less would win now.
  std::swap(registration, other_registration);
  std::swap(score, other_score);
  return std::nullopt;
}

}  // namespace deepslam::modelling
