// loops: places seen again, by their appearance and by constellations of objects; the objects that
// loops join compete for their shape anew.
#include <algorithm>
#include <array>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/association_json.h"
#include "deepslam/artifact/loops_json.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/core/side_by_side.h"
#include "deepslam/mapping/close_by_appearance.h"
#include "deepslam/modelling/close_loops.h"
#include "deepslam/stages/object_sources.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using modelling::ClosedMap;
using modelling::MapWithLoops;
using pipeline::StageContext;
using pipeline::StageSummary;

Result<MapWithLoops> ReadMap(const StageContext& context) {
  MapWithLoops map;
  const std::array<std::function<Status()>, 5> readers = {
      [&] { return Take(ReadOdometry(context), map.odometry); },
      [&] { return Take(ReadGround(context, "ground"), map.ground); },
      [&] { return Take(ReadAssociation(context, "associate"), map.association); },
      [&] { return Take(ReadCandidates(context, "select"), map.proposals); },
      [&] { return Take(ReadObjects(context, "select"), map.map); }};
  if (Status status = RunSideBySide(readers); !status.ok()) return status.error();
  map.tracked = static_cast<const Trajectory&>(map.odometry);
  return map;
}

mapping::AppearanceClosing AppearanceOptions(const Config& config) {
  mapping::AppearanceClosing options{
      config.appearance, config.track.alignment, config.optimize, false};
  options.appearance.enabled &= config.loops.enabled;
  options.by_depth_alone =
      config.track_stage.poses != "capture" && !config.track.alignment.photometric;
  return options;
}

Result<ClosedMap> CloseByObjects(const StageContext& context,
                                 const RunInputs& inputs,
                                 MapWithLoops map) {
  const Config& config = inputs.config;
  const auto views = OpenViews(context, *inputs.capture->frames, inputs.classes, config.views);
  if (!views.ok()) return views.error();
  const StageModels models(context);
  const modelling::ObjectSources sources{*views, models, *inputs.prepared, context.progress()};
  const Result<Layout> layout = ReadLayout(context);
  if (!layout.ok()) return layout.error();
  modelling::ObjectOptions objects = ObjectOptionsOf(config, inputs.overrides);
  objects.layout = &*layout;
  objects.classes = &inputs.classes;
  return modelling::CloseLoops(std::move(map),
                               {sources, inputs.classes, objects, config.loops, config.optimize});
}

Status Write(StageContext& context, const ClosedMap& closed) {
  const Status written = WriteFiles(
      context,
      {{"loops.json", [&] { return artifact::EncodeLoops(closed.loops, "loops.json"); }},
       {"objects.json", [&] { return artifact::EncodeObjectMap(closed.map, "objects.json"); }},
       {"candidates.json",
        [&] { return artifact::EncodeProposals(closed.made, "candidates.json"); }},
       {"registrations.json",
        [&] { return artifact::EncodeRegistrations(closed.registrations, "registrations.json"); }},
       {"tracks.json",
        [&] { return artifact::EncodeAssociation(closed.association, "tracks.json"); }}});
  if (!written.ok()) return written;
  if (Status status = WriteModels(context, closed.made.models); !status.ok()) return status;
  return CopyChosenModels(context, closed.map, closed.made.models);
}

StageSummary Summary(const Loops& loops, int num_reregistered, std::size_t num_objects) {
  const auto accepted = std::ranges::count_if(loops.constellations, &Constellation::accepted);
  const auto seen_again = std::ranges::count_if(loops.appearance, &AppearanceLoop::accepted);
  return StageSummary{
      fmt::format("{} of {} constellations and {} of {} loops by appearance accepted, {} "
                  "neighbours re-registered, {} objects merged, {} edges; {} objects",
                  accepted,
                  loops.constellations.size(),
                  seen_again,
                  loops.appearance.size(),
                  num_reregistered,
                  loops.merges.size(),
                  loops.edges.size(),
                  num_objects),
      {{"num_accepted", static_cast<double>(accepted)},
       {"num_appearance", static_cast<double>(seen_again)},
       {"num_measured_again", static_cast<double>(num_reregistered)},
       {"num_merges", static_cast<double>(loops.merges.size())},
       {"num_edges", static_cast<double>(loops.edges.size())},
       {"num_objects", static_cast<double>(num_objects)}}};
}

}  // namespace

Result<StageSummary> RunLoops(StageContext& context, const RunInputs& inputs) {
  Result<MapWithLoops> map = ReadMap(context);
  if (!map.ok()) return map.error();
  Result<mapping::ClosedTrajectory> by_appearance =
      mapping::CloseByAppearance(*inputs.capture->frames,
                                 map->odometry,
                                 map->ground,
                                 AppearanceOptions(inputs.config),
                                 context.progress());
  if (!by_appearance.ok()) return by_appearance.error();
  map->odometry.frames = std::move(by_appearance->frames);
  map->ground = std::move(by_appearance->ground);
  map->appearance = std::move(by_appearance->appearance);
  const Result<ClosedMap> closed = CloseByObjects(context, inputs, std::move(map).value());
  if (!closed.ok()) return closed.error();
  if (Status status = Write(context, *closed); !status.ok()) return status.error();
  return Summary(closed->loops, by_appearance->num_reregistered, closed->map.objects.size());
}

}  // namespace deepslam::stages
