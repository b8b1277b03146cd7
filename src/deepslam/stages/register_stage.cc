// register: where every candidate stands in every view of its object.
#include <algorithm>

#include <fmt/format.h>

#include "deepslam/artifact/registrations_json.h"
#include "deepslam/modelling/register_objects.h"
#include "deepslam/stages/object_sources.h"
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
  const Result<Layout> layout = ReadLayout(context);
  if (!layout.ok()) return layout.error();
  const Result<Association> association = ReadAssociation(context, "associate");
  if (!association.ok()) return association.error();
  const Result<Proposals> proposals = ReadProposals(context);
  if (!proposals.ok()) return proposals.error();
  const auto views =
      OpenViews(context, *inputs.capture->frames, inputs.classes, inputs.config.views);
  if (!views.ok()) return views.error();

  modelling::ObjectOptions options = ObjectOptionsOf(inputs.config, inputs.overrides);
  options.layout = &*layout;
  options.classes = &inputs.classes;
  const auto registrations = modelling::RegisterObjects(
      {association->tracks, *trajectory, *ground},
      *proposals,
      {*views, StageModels(context), *inputs.prepared, context.progress()},
      options);
  if (!registrations.ok()) return registrations.error();
  if (Status status =
          WriteEncoded(context,
                       "registrations.json",
                       artifact::EncodeRegistrations(*registrations, "registrations.json"));
      !status.ok()) {
    return status.error();
  }
  const auto placed = std::ranges::count_if(*registrations, &CandidateRegistration::ok);
  return StageSummary{fmt::format("{} of {} candidates placed", placed, registrations->size()),
                      {{"num_placed", static_cast<double>(placed)},
                       {"num_candidates", static_cast<double>(registrations->size())}}};
}

}  // namespace deepslam::stages
