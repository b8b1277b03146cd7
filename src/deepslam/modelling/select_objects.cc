#include "deepslam/modelling/select_objects.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/modelling/candidate_set.h"
#include "deepslam/modelling/refine_candidates.h"
#include "deepslam/propose/shape_prior.h"
#include "deepslam/scene/object_map.h"

namespace deepslam::modelling {
namespace {

Result<std::vector<CandidateRegistration>> RegistrationsOf(
    std::span<const ShapeCandidate> candidates, std::span<const CandidateRegistration> all) {
  std::vector<CandidateRegistration> found;
  for (const ShapeCandidate& candidate : candidates) {
    const auto it = std::ranges::find(all, candidate.id, &CandidateRegistration::candidate);
    if (it == all.end()) {
      return InvalidInput(fmt::format(
          "candidate {} was proposed and not registered; register it first", candidate.id.value));
    }
    found.push_back(*it);
  }
  return found;
}

void Place(MapObject object, ObjectMap& map) {
  if (object.chosen.valid()) {
    map.objects.push_back(std::move(object));
    return;
  }
  map.dropped.push_back(fmt::format(
      "{}: {}", ObjectName(object), object.note.empty() ? "no candidate" : object.note));
}

// Why an object that nobody names is none of the map.
std::string WhyDoubted(const ObjectTrack& track,
                       const MapObject& object,
                       const select::SelectOptions& options) {
  if (track.is_named() || !object.chosen.valid() ||
      object.confidence >= options.min_unnamed_confidence)
    return {};
  return fmt::format("no detection names it, and its confidence of {:.2f} is below {}",
                     object.confidence,
                     options.min_unnamed_confidence);
}

// What no prior knows the shape of is no more than what was measured of it, which one or two views
// do not make a shape.
constexpr std::size_t kMinMeasuredViews = 3;

bool IsMeasuredAlone(std::span<const ShapeCandidate> candidates) {
  return std::ranges::all_of(candidates,
                             [](const ShapeCandidate& c) { return TraitsOf(c.source).is_partial; });
}

std::string WhyUnmeasured(const CandidateSet& set, std::size_t num_views) {
  if (!IsMeasuredAlone(set.candidates) || num_views >= kMinMeasuredViews) return {};
  return fmt::format("no shape is known for it, and {} measured it",
                     num_views == 1 ? "a single view" : fmt::format("{} views", num_views));
}

MapObject LeftOut(const MapObject& object, const std::string& why) {
  MapObject left_out;
  left_out.id = object.id;
  left_out.class_name = object.class_name;
  left_out.note = why;
  return left_out;
}

const propose::ShapePrior* PriorOf(const propose::ShapePriors* priors,
                                   const std::string& class_name) {
  if (priors == nullptr) return nullptr;
  const auto found = priors->find(class_name);
  return found != priors->end() && found->second->HasGradient() ? found->second.get() : nullptr;
}

// One object's candidates when all are scored, with what was made for it: numbered from behind the
// proposed on, as if no other object had any.
struct ScoredObject {
  CandidateSet set;
  std::size_t num_proposed = 0;         // those made here are behind them
  Proposals made;                       // the same, with their models
  std::optional<std::size_t> replaced;  // of the proposed, whose registration was refined
};

class ObjectSelection {
 public:
  ObjectSelection(const RegisteredCandidates& candidates,
                  const ObjectSources& sources,
                  const ObjectOptions& options)
      : candidates_(candidates),
        sources_(sources),
        options_(options),
        first_made_(NextId(candidates.proposals)),
        has_priors_(!IsMeasuredAlone(candidates.proposals.candidates)) {}

  // Thread-safe.
  [[nodiscard]] Result<ScoredObject> Score(const TrackViews& of_track) const {
    Result<ScoredObject> scored = ScoreProposed(of_track);
    if (!scored.ok()) return scored;
    CandidateSet& set = scored->set;
    if (const propose::ShapePrior* const prior = PriorOf(candidates_.priors, set.class_name))
      Add(RefineShapes(set, of_track.views, *prior, options_), of_track.views, *scored);
    if (options_.refinement.complete)
      Add(CompleteBest(set, of_track.views, "filled", options_), of_track.views, *scored);
    scored->replaced = RefineWinner(of_track.views, options_, set);
    return scored;
  }

  // The object's winner, and what was made for it, into the selection.
  [[nodiscard]] Status Keep(const TrackViews& of_track, ScoredObject scored) {
    NumberBehind(static_cast<int>(selection_.made.candidates.size()), scored);
    Append(std::move(scored.made), selection_.made);
    const CandidateSet& set = scored.set;
    std::vector<CandidateRegistration>& made_registrations = selection_.made_registrations;
    if (scored.replaced && *scored.replaced < scored.num_proposed)
      made_registrations.push_back(set.registrations[*scored.replaced]);
    const auto made = std::span(set.registrations).subspan(scored.num_proposed);
    made_registrations.insert(made_registrations.end(), made.begin(), made.end());
    const std::size_t num_applied = selection_.applied.size();
    Result<MapObject> object = SelectOrChoose(set, of_track.views, options_, selection_.applied);
    if (!object.ok()) return object.error();
    object->class_votes = of_track.track->class_votes;
    const bool is_choice = selection_.applied.size() > num_applied;
    std::string why = WhyDoubted(*of_track.track, *object, options_.select);
    if (why.empty() && object->chosen.valid() && has_priors_)
      why = WhyUnmeasured(set, of_track.views.size());
    if (!why.empty() && !is_choice) *object = LeftOut(*object, why);
    Place(std::move(object).value(), selection_.map);
    return Ok();
  }

  [[nodiscard]] Selection Take() && { return std::move(selection_); }

 private:
  [[nodiscard]] Result<ScoredObject> ScoreProposed(const TrackViews& of_track) const {
    const ObjectTrack& track = *of_track.track;
    ScoredObject scored;
    CandidateSet& set = scored.set;
    set.object = track.id;
    set.class_name = track.class_name;
    set.candidates = CandidatesOf(candidates_.proposals, track.id);
    Result<std::vector<CandidateRegistration>> own =
        RegistrationsOf(set.candidates, candidates_.registrations);
    if (!own.ok()) return own.error();
    set.registrations = std::move(own).value();
    Result<ModelMap> models = LoadModels(set.candidates, sources_.models, sources_.prepared);
    if (!models.ok()) return models.error();
    set.models = std::move(models).value();
    ScoreAll(of_track.views, options_, set);
    scored.num_proposed = set.candidates.size();
    return scored;
  }

  void Add(Proposals made, std::span<const ObjectView> views, ScoredObject& scored) const {
    NumberFrom(first_made_ + static_cast<int>(scored.made.candidates.size()), made);
    AddCandidates(made, views, options_, sources_.prepared, scored.set);
    Append(std::move(made), scored.made);
  }

  // Numbers what was made for the object behind what was made for those before it.
  static void NumberBehind(int num_before, ScoredObject& scored) {
    for (ShapeCandidate& candidate : scored.made.candidates) candidate.id.value += num_before;
    CandidateSet& set = scored.set;
    for (std::size_t n = scored.num_proposed; n < set.candidates.size(); ++n) {
      set.candidates[n].id.value += num_before;
      set.registrations[n].candidate.value += num_before;
      set.scores[n].candidate.value += num_before;
    }
  }

  const RegisteredCandidates& candidates_;
  const ObjectSources& sources_;
  const ObjectOptions& options_;
  const int first_made_;
  const bool has_priors_;  // for some object; without any, what was measured is all there is
  Selection selection_;
};

}  // namespace

Result<Selection> SelectObjects(const TrackedObjects& objects,
                                const RegisteredCandidates& candidates,
                                const ObjectSources& sources,
                                const ObjectOptions& options) {
  ObjectSelection selection(candidates, sources, options);
  const PerTrack<ScoredObject> work = {
      [&](const TrackViews& of_track) { return selection.Score(of_track); },
      [&](const TrackViews& of_track, ScoredObject scored) {
        return selection.Keep(of_track, std::move(scored));
      }};
  const Status status =
      ForEachTrack(sources.views, objects, observe::ViewContent::kDepth, sources.progress, work);
  if (!status.ok()) return status.error();
  return std::move(selection).Take();
}

}  // namespace deepslam::modelling
