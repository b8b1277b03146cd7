// register: where every candidate stands in every view of its object.
#include <algorithm>

#include <fmt/format.h>

#include "deepslam/artifact/registrations_json.h"
#include "deepslam/stages/judge_object.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

Result<StageSummary> RunRegister(StageContext& context, const RunInputs& inputs) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Association> association = ReadAssociation(context, "associate");
  if (!association.ok()) return association.error();
  const Result<Proposals> proposals = ReadProposals(context);
  if (!proposals.ok()) return proposals.error();

  using Registrations = std::vector<CandidateRegistration>;
  const auto register_all = [&](const TrackViews& of_track) -> Result<Registrations> {
    const std::vector<ShapeCandidate> candidates = CandidatesOf(*proposals, of_track.track->id);
    const Result<ModelMap> models = LoadModels(context, inputs, candidates);
    if (!models.ok()) return models.error();
    return RegisterAll(candidates, *models, of_track.views, inputs.config.registration);
  };
  Registrations registrations;
  const auto append = [&](const TrackViews&, Registrations found) {
    std::move(found.begin(), found.end(), std::back_inserter(registrations));
    return Ok();
  };
  const Status registered = ForEachTrackViews<Registrations>(context,
                                                             inputs,
                                                             *trajectory,
                                                             *ground,
                                                             association->tracks,
                                                             observe::ViewContent::kDepth,
                                                             register_all,
                                                             append);
  if (!registered.ok()) return registered.error();
  std::stable_sort(registrations.begin(),
                   registrations.end(),
                   [](const CandidateRegistration& a, const CandidateRegistration& b) {
                     return a.candidate < b.candidate;
                   });
  if (Status status =
          WriteEncoded(context,
                       "registrations.json",
                       artifact::EncodeRegistrations(registrations, "registrations.json"));
      !status.ok()) {
    return status.error();
  }
  const auto placed = std::count_if(
      registrations.begin(), registrations.end(), [](const CandidateRegistration& registration) {
        return registration.ok;
      });
  return StageSummary{fmt::format("{} of {} candidates placed", placed, registrations.size()),
                      {{"num_placed", static_cast<double>(placed)},
                       {"num_candidates", static_cast<double>(registrations.size())}}};
}

}  // namespace deepslam::stages
