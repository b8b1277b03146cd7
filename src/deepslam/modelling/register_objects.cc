#include "deepslam/modelling/register_objects.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "deepslam/modelling/candidate_set.h"

namespace deepslam::modelling {

Result<std::vector<CandidateRegistration>> RegisterObjects(const TrackedObjects& objects,
                                                           const Proposals& proposals,
                                                           const ObjectSources& sources,
                                                           const ObjectOptions& options) {
  using Registrations = std::vector<CandidateRegistration>;
  const auto register_all = [&](const TrackViews& of_track) -> Result<Registrations> {
    const std::vector<ShapeCandidate> candidates = CandidatesOf(proposals, of_track.track->id);
    const Result<ModelMap> models = LoadModels(candidates, sources.models, sources.prepared);
    if (!models.ok()) return models.error();
    return RegisterAll(candidates, *models, of_track.views, of_track.track->class_name, options);
  };
  Registrations registrations;
  const auto append = [&](const TrackViews&, Registrations found) {
    std::ranges::move(found, std::back_inserter(registrations));
    return Ok();
  };
  const PerTrack<Registrations> work{register_all, append};
  const Status registered =
      ForEachTrack(sources.views, objects, observe::ViewContent::kDepth, sources.progress, work);
  if (!registered.ok()) return registered.error();
  std::ranges::stable_sort(registrations, {}, &CandidateRegistration::candidate);
  return registrations;
}

}  // namespace deepslam::modelling
