#include "priors_look.h"

#include <memory>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/dataset/capture.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/priors/proposal_sheet.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/proposal_look.h"

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

std::optional<priors::SeenShape> Seen(const std::optional<stages::LookedShape>& looked) {
  if (!looked) return std::nullopt;
  return priors::SeenShape{looked->shape, looked->azimuth_rad, looked->elevation_rad};
}

// The library's model is drawn from where the network with depth believes the camera to be: it has
// no opinion of its own.
priors::ProposalRow RowOf(const stages::ProposalLook& look) {
  priors::ProposalRow row;
  row.crop = look.crop;
  row.shapes = {Seen(look.by_colour), Seen(look.by_depth)};
  std::optional<priors::SeenShape> retrieved;
  if (look.retrieved && look.by_depth)
    retrieved = {*look.retrieved, look.by_depth->azimuth_rad, look.by_depth->elevation_rad};
  row.shapes.push_back(std::move(retrieved));
  return row;
}

Result<std::vector<stages::ProposalLook>> LookAt(const LookArguments& arguments) {
  const Result<stages::Config> config = ReadConfig(arguments.config);
  if (!config.ok()) return config.error();
  const Result<ClassTable> classes = stages::LoadClasses(*config);
  if (!classes.ok()) return classes.error();
  Result<dataset::Capture> opened = dataset::OpenCapture(arguments.capture);
  if (!opened.ok()) return opened.error();
  const auto capture = std::make_shared<const dataset::Capture>(std::move(opened).value());
  const stages::RunInputs inputs{
      *config, *classes, capture, stages::FindDataFolder(arguments.data_folder)};
  SilentProgress progress;
  return stages::LookAtProposals(arguments.workspace, inputs, arguments.max_views, progress);
}

int Look(const LookArguments& arguments) {
  const Result<std::vector<stages::ProposalLook>> looks = LookAt(arguments);
  if (!looks.ok()) return ReportError(looks.error());
  if (looks->empty())
    return ReportError(
        InvalidInput(arguments.workspace + ": no object of a class that has networks"));
  std::vector<priors::ProposalRow> rows;
  for (std::size_t n = 0; n < looks->size(); ++n) {
    const stages::ProposalLook& look = (*looks)[n];
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
