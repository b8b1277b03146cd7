#include "priors_look.h"

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/layouts/open_capture.h"
#include "deepslam/modelling/proposal_look.h"
#include "deepslam/priors/proposal_sheet.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/model_cache.h"
#include "deepslam/stages/object_sources.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::tools {
namespace {

struct LookArguments {
  std::string workspace;
  std::string capture;
  std::string sheet;
  std::string data_folder;
  int max_views = 3;
  ConfigSources config;
};

std::optional<priors::SeenShape> Seen(const std::optional<modelling::LookedShape>& looked) {
  if (!looked) return std::nullopt;
  return priors::SeenShape{looked->shape, looked->azimuth_rad, looked->elevation_rad};
}

// The library's model is drawn from where the network with depth believes the camera to be: it has
// no opinion of its own.
priors::ProposalRow RowOf(const modelling::ProposalLook& look) {
  priors::ProposalRow row;
  row.crop = look.crop;
  row.shapes = {Seen(look.by_colour), Seen(look.by_depth)};
  std::optional<priors::SeenShape> retrieved;
  if (look.retrieved && look.by_depth)
    retrieved = {*look.retrieved, look.by_depth->azimuth_rad, look.by_depth->elevation_rad};
  row.shapes.push_back(std::move(retrieved));
  return row;
}

// The first library model of every object.
Result<std::map<ObjectId, VoxelGrid>> FirstRetrieved(const pipeline::StageContext& context) {
  const Result<Proposals> proposals = stages::ReadProposals(context);
  if (!proposals.ok()) return proposals.error();
  std::map<ObjectId, VoxelGrid> first;
  for (const ShapeCandidate& candidate : proposals->candidates) {
    if (candidate.library_id.empty() || first.contains(candidate.object)) continue;
    Result<VoxelGrid> model = stages::ReadModel(context, "propose", candidate.model);
    if (!model.ok()) return model.error();
    first.emplace(candidate.object, std::move(model).value());
  }
  return first;
}

// InvalidInput when the workspace lacks stage `propose` or was made of another capture, or there
// are no networks.
Result<std::vector<modelling::ProposalLook>> LookAtWorkspace(const std::string& workspace,
                                                             const stages::RunInputs& inputs,
                                                             int max_views) {
  SilentProgress progress;
  const pipeline::StageContext context(
      workspace, {}, {"track", "ground", "segment", "associate", "propose"}, progress);
  const FrameSource& frames = *inputs.capture->frames;
  const auto priors = stages::FindShapePriors(
      {inputs.data_folder, {}}, inputs.config.propose_stage.priors, inputs.classes);
  if (!priors.ok()) return priors.error();
  if (!*priors) return InvalidInput("no shape networks are there; name a folder by propose.priors");
  const Result<Trajectory> trajectory = stages::ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<std::vector<Segment>> segments = stages::ReadSegments(context, "associate");
  if (!segments.ok()) return segments.error();
  if (const Status status =
          stages::CheckOfThisCapture(trajectory->frames.size(), *segments, frames);
      !status.ok())
    return status.error();
  const Result<Ground> ground = stages::ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Association> association = stages::ReadAssociation(context, "associate");
  if (!association.ok()) return association.error();
  const Result<std::map<ObjectId, VoxelGrid>> retrieved = FirstRetrieved(context);
  if (!retrieved.ok()) return retrieved.error();
  const auto views = stages::OpenViews(context, frames, inputs.classes, inputs.config.views);
  if (!views.ok()) return views.error();
  return modelling::LookAtProposals(
      {association->tracks, *trajectory, *ground}, **priors, *retrieved, *views, max_views);
}

Result<std::vector<modelling::ProposalLook>> LookAt(const LookArguments& arguments) {
  const Result<stages::Config> config = ReadConfig(arguments.config);
  if (!config.ok()) return config.error();
  const Result<ClassTable> classes = stages::LoadClasses(*config);
  if (!classes.ok()) return classes.error();
  Result<dataset::Capture> opened = layouts::OpenCapture(arguments.capture);
  if (!opened.ok()) return opened.error();
  const auto capture = std::make_shared<const dataset::Capture>(std::move(opened).value());
  const stages::RunInputs inputs{
      *config, *classes, capture, stages::FindDataFolder(arguments.data_folder)};
  return LookAtWorkspace(arguments.workspace, inputs, arguments.max_views);
}

int Look(const LookArguments& arguments) {
  const Result<std::vector<modelling::ProposalLook>> looks = LookAt(arguments);
  if (!looks.ok()) return ReportError(looks.error());
  if (looks->empty())
    return ReportError(
        InvalidInput(arguments.workspace + ": no object of a class that has networks"));
  std::vector<priors::ProposalRow> rows;
  for (std::size_t n = 0; n < looks->size(); ++n) {
    const modelling::ProposalLook& look = (*looks)[n];
    rows.push_back(RowOf(look));
    fmt::print(stderr,
               "row {:>3}: {}, frame {}{}\n",
               n + 1,
               look.object,
               look.frame.value,
               look.note.empty() ? "" : ": " + look.note);
  }
  const Status written = dataset::WriteColourFile(arguments.sheet, priors::DrawProposalSheet(rows));
  return written.ok() ? kExitOk : ReportError(written.error());
}

}  // namespace

void AddPriorsLook(CLI::App& priors, Command& chosen) {
  auto arguments = std::make_shared<LookArguments>();
  CLI::App* look = priors.add_subcommand(
      "look",
      "Draw what the networks make of a capture's objects: crop, depth, shape by colour alone, by "
      "colour and depth, the library's first");
  look->add_option("WORKSPACE", arguments->workspace, "Workspace of a run, propose done")
      ->required();
  look->add_option("CAPTURE", arguments->capture, "The capture it was made of")->required();
  look->add_option("--sheet", arguments->sheet, "Picture to write (PNG)")->required();
  look->add_option("--views", arguments->max_views, "Views of each object")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  look->add_option("--data", arguments->data_folder, "Folder of weights and furniture library");
  AddConfigOptions(*look, arguments->config);
  look->callback([&chosen, arguments] { chosen = [arguments] { return Look(*arguments); }; });
}

}  // namespace deepslam::tools
