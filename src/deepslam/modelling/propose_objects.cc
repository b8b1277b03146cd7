#include "deepslam/modelling/propose_objects.h"

#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/modelling/candidate_set.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/scene/object_name.h"

namespace deepslam::modelling {
namespace {

// What all sources say of one object, in their order. Candidates have no numbers yet.
Result<Proposals> ProposeOne(const CandidateSources& sources, const TrackViews& of_track) {
  const ObjectTrack& track = *of_track.track;
  const std::string name = ObjectName(track.class_name, track.id);
  Proposals all;
  if (of_track.views.empty()) {
    all.notes.push_back(name + ": no view could be read");
    return all;
  }
  propose::ObjectObservations object{track.id, track.class_name, of_track.views};
  object.is_named = track.is_named();
  object.layout = sources.layout;
  std::optional<propose::LevelCloud> cloud;
  if (sources.use_depth) {
    cloud = propose::AccumulateLevel(object.views);
    object.cloud = &*cloud;
  }
  const std::size_t num_sources = sources.proposers.size();
  std::vector<std::optional<Result<Proposals>>> answers(num_sources);
  ParallelFor(num_sources,
              [&](std::size_t s) { answers[s] = sources.proposers[s]->Propose(object); });
  for (std::size_t s = 0; s < num_sources; ++s) {
    if (!answers[s]->ok()) {
      return Error{
          answers[s]->error().code,
          fmt::format("source {}: {}", sources.proposers[s]->name(), answers[s]->error().message)};
    }
    Proposals answer = std::move(*answers[s]).value();
    for (std::string& note : answer.notes) note = fmt::format("{}: {}", name, note);
    Append(std::move(answer), all);
  }
  return all;
}

}  // namespace

Result<Proposals> ProposeObjects(const TrackedObjects& objects,
                                 const CandidateSources& sources,
                                 const ViewSource& views,
                                 Progress& progress) {
  Proposals all;
  const PerTrack<Proposals> work = {
      [&](const TrackViews& of_track) { return ProposeOne(sources, of_track); },
      [&](const TrackViews&, Proposals of_object) {
        NumberFrom(static_cast<int>(all.candidates.size()), of_object);
        Append(std::move(of_object), all);
        return Ok();
      }};
  const Status status =
      ForEachTrack(views, objects, observe::ViewContent::kColourAndDepth, progress, work);
  if (!status.ok()) return status.error();
  return all;
}

}  // namespace deepslam::modelling
