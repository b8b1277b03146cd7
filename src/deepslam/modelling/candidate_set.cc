#include "deepslam/modelling/candidate_set.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/registration/register_shape.h"
#include "deepslam/scene/sides_at_walls.h"
#include "deepslam/select/agreement.h"
#include "deepslam/select/confidence.h"
#include "deepslam/select/select.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::modelling {
namespace {

// The winner of `count` candidates from `first` on.
MapObject SelectOf(const CandidateSet& set,
                   std::size_t first,
                   std::size_t count,
                   std::span<const ObjectView> views,
                   const select::SelectOptions& options) {
  return select::SelectShape(set.object,
                             set.class_name,
                             std::span(set.candidates).subspan(first, count),
                             std::span(set.registrations).subspan(first, count),
                             std::span(set.scores).subspan(first, count),
                             views,
                             options);
}

MapObject WithConfidence(const CandidateSet& set, MapObject object) {
  if (!object.chosen.valid()) return object;
  object.confidence = select::Confidence(
      object, *set.models.at(object.model), set.candidates, set.registrations, set.scores);
  return object;
}

// The room for what has a front.
const Layout* LayoutForFront(std::string_view class_name, const ObjectOptions& options) {
  const bool has_front =
      options.classes == nullptr || !options.classes->TraitsOf(class_name).yaw_free;
  return has_front ? options.layout : nullptr;
}

Similarity3 TrackingFromObject(const CandidateRegistration& registration) {
  return Similarity3::From(registration.world_from_object, registration.scale_m);
}

double WallConflictOf(const shape::ShapeModel& model,
                      const CandidateRegistration& registration,
                      const Layout& layout) {
  if (!registration.ok || model.empty()) return 0;
  return WallConflict(layout, TrackingFromObject(registration), model.box());
}

bool FacesWall(std::size_t i, const CandidateSet& set, const Layout& layout) {
  const shape::ShapeModel& model = *set.models.at(set.candidates[i].model);
  return set.registrations[i].ok && !model.empty() &&
         FrontBlocked(layout, TrackingFromObject(set.registrations[i]), model.box()) >= 1;
}

// The candidate's model, which no other candidate has, turned in its own frame; the surface stays
// where it is in the world, so that its score does too.
void TurnHalfRound(std::size_t i, Proposals& made, PreparedModels& prepared, CandidateSet& set) {
  constexpr int kHalfTurn = 2;  // quarters
  const std::string name = set.candidates[i].model;
  VoxelGrid& grid = made.models.at(name);
  grid = shape::TurnGrid(grid, kHalfTurn);
  set.models[name] = prepared.Prepare(name, grid);
  CandidateRegistration& registration = set.registrations[i];
  const Eigen::Quaterniond half_turn(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  registration.world_from_object.rotation = registration.world_from_object.rotation * half_turn;
  for (std::vector<ShapeCandidate>* const list : {&set.candidates, &made.candidates}) {
    const auto turned = std::ranges::find(*list, name, &ShapeCandidate::model);
    if (turned == list->end() || !turned->world_from_object) continue;
    turned->world_from_object->rotation = turned->world_from_object->rotation * half_turn;
  }
  Eigen::Vector<double, 6> signs;  // of (translation; rotation) in the turned frame
  signs << -1, -1, 1, -1, -1, 1;
  for (ViewRegistration& view : registration.views) {
    view.camera_from_object.rotation = view.camera_from_object.rotation * half_turn;
    view.information = (signs.asDiagonal() * view.information * signs.asDiagonal()).eval();
  }
  set.scores[i].front_blocked = 0;
}

Error FitsNowhere(const CandidateSet& set, std::size_t n, const HandChoice& choice) {
  const std::string& why = set.scores[n].note;
  return InvalidConfig(fmt::format(
      "{}: choose: candidate {} of object {} fits nowhere: {}; choose another one, or none",
      choice.file,
      set.candidates[n].id.value,
      set.object.value,
      why.empty() ? "it agrees with none of the depth" : why));
}

}  // namespace

Result<ModelMap> LoadModels(std::span<const ShapeCandidate> candidates,
                            const ModelSource& source,
                            PreparedModels& prepared,
                            const GridMap& made) {
  GridMap grids;
  for (const ShapeCandidate& candidate : candidates) {
    if (grids.contains(candidate.model)) continue;
    if (const auto own = made.find(candidate.model); own != made.end()) {
      grids.insert(*own);
      continue;
    }
    Result<VoxelGrid> grid = source.Read(candidate.source, candidate.model);
    if (!grid.ok()) return grid.error();
    grids.emplace(candidate.model, std::move(grid).value());
  }
  return PrepareModels(grids, prepared);
}

ModelMap PrepareModels(const GridMap& grids, PreparedModels& prepared) {
  ModelMap models;
  std::vector<std::pair<ModelMap::iterator, const VoxelGrid*>> places;
  for (const auto& [name, grid] : grids)
    places.emplace_back(models.emplace(name, nullptr).first, &grid);
  ParallelFor(places.size(), [&](std::size_t i) {
    const auto& [place, grid] = places[i];
    place->second = prepared.Prepare(place->first, *grid);
  });
  return models;
}

std::vector<ShapeCandidate> CandidatesOf(const Proposals& proposals, ObjectId object) {
  std::vector<ShapeCandidate> candidates;
  for (const ShapeCandidate& candidate : proposals.candidates) {
    if (candidate.object == object) candidates.push_back(candidate);
  }
  return candidates;
}

void Append(Proposals more, Proposals& all) {
  std::ranges::move(more.candidates, std::back_inserter(all.candidates));
  std::ranges::move(more.notes, std::back_inserter(all.notes));
  all.models.merge(more.models);
}

int NextId(const Proposals& proposals) {
  int next = 0;
  for (const ShapeCandidate& candidate : proposals.candidates)
    next = std::max(next, candidate.id.value + 1);
  return next;
}

void NumberFrom(int first_id, Proposals& proposals) {
  for (ShapeCandidate& candidate : proposals.candidates) candidate.id = CandidateId{first_id++};
}

std::vector<CandidateRegistration> RegisterAll(std::span<const ShapeCandidate> candidates,
                                               const ModelMap& models,
                                               std::span<const ObjectView> views,
                                               std::string_view class_name,
                                               const ObjectOptions& options) {
  const auto prepared = registration::PrepareForRegistration(views);
  const Layout* const layout = LayoutForFront(class_name, options);
  std::vector<CandidateRegistration> registrations(candidates.size());
  ParallelFor(candidates.size(), [&](std::size_t i) {
    registrations[i] = registration::RegisterCandidate(candidates[i],
                                                       *models.at(candidates[i].model),
                                                       std::span(prepared),
                                                       options.registration,
                                                       layout);
  });
  return registrations;
}

void ScoreAll(std::span<const ObjectView> views, const ObjectOptions& options, CandidateSet& set) {
  if (set.scored_views.empty()) set.scored_views = select::PrepareForScoring(views);
  const Layout* const layout = LayoutForFront(set.class_name, options);
  const std::size_t first = set.scores.size();
  set.scores.resize(set.candidates.size());
  ParallelFor(set.candidates.size() - first, [&](std::size_t n) {
    const std::size_t i = first + n;
    const shape::ShapeModel& model = *set.models.at(set.candidates[i].model);
    set.scores[i] = select::ScoreCandidate(set.candidates[i],
                                           model,
                                           set.registrations[i],
                                           std::span(std::as_const(set.scored_views)),
                                           options.select);
    if (layout != nullptr)
      set.scores[i].front_blocked = WallConflictOf(model, set.registrations[i], *layout);
  });
}

void AddCandidates(Proposals& made,
                   std::span<const ObjectView> views,
                   const ObjectOptions& options,
                   PreparedModels& prepared,
                   CandidateSet& set) {
  set.models.merge(PrepareModels(made.models, prepared));
  std::vector<CandidateRegistration> registrations =
      RegisterAll(made.candidates, set.models, views, set.class_name, options);
  for (std::size_t n = 0; n < made.candidates.size(); ++n) {
    set.candidates.push_back(made.candidates[n]);
    set.registrations.push_back(std::move(registrations[n]));
  }
  const std::size_t first = set.scores.size();
  ScoreAll(views, options, set);
  const Layout* const layout = LayoutForFront(set.class_name, options);
  for (std::size_t i = first; i < set.candidates.size() && layout != nullptr; ++i) {
    if (TraitsOf(set.candidates[i].source).follows_depth && FacesWall(i, set, *layout))
      TurnHalfRound(i, made, prepared, set);
  }
}

Result<MapObject> SelectOrChoose(const CandidateSet& set,
                                 std::span<const ObjectView> views,
                                 const ObjectOptions& options,
                                 std::vector<std::string>& applied) {
  MapObject best = SelectOf(set, 0, set.candidates.size(), views, options.select);
  if (!options.choice.choose) return WithConfidence(set, std::move(best));
  const Result<CandidateId> wanted = options.choice.choose(set.object, set.candidates);
  if (!wanted.ok()) return wanted.error();
  if (!wanted->valid() || *wanted == best.chosen) return WithConfidence(set, std::move(best));
  const auto found = std::ranges::find(set.candidates, *wanted, &ShapeCandidate::id);
  const auto n = static_cast<std::size_t>(found - set.candidates.begin());
  MapObject chosen = SelectOf(set, n, 1, views, options.select);
  if (!chosen.chosen.valid()) return FitsNowhere(set, n, options.choice);
  chosen.note += chosen.note.empty() ? "chosen by hand" : "; chosen by hand";
  chosen.scores = std::move(best.scores);
  chosen.history = std::move(best.history);
  applied.push_back(fmt::format(
      "object {} is candidate {} ({}) by choice", set.object.value, wanted->value, chosen.model));
  return WithConfidence(set, std::move(chosen));
}

}  // namespace deepslam::modelling
