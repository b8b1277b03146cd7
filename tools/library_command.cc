#include <chrono>
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "catalogues.h"
#include "commands.h"
#include "console.h"
#include "deepslam/core/sha256.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/plan.h"
#include "deepslam/storage/store.h"
#include "number_from.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

// Beside the library: from what it was made, so that it is not made again in vain.
constexpr std::string_view kSourceStamp = ".made_from";

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct LibraryArguments {
  std::string catalogues = kCatalogueFolder;
  std::string out;
  std::string withheld;
  std::string data;
  bool force = false;
};

// Hash of everything the library depends on.
Result<std::string> SourceHash(const LibraryArguments& arguments,
                               const std::vector<std::string>& withheld) {
  const Result<std::string> catalogues = storage::HashFolder(arguments.catalogues);
  if (!catalogues.ok()) return catalogues.error();
  std::string text = fmt::format("{} {}", stages::kToolVersion, *catalogues);
  for (const std::string& id : withheld) text += "\n" + id;
  return Sha256Hex(text);
}

Result<std::vector<std::string>> Withheld(const std::string& file) {
  if (file.empty()) return std::vector<std::string>();
  return library::ReadWithheldModels(file);
}

// The products of the sample capture are withheld by default where their list is at hand.
std::string DefaultWithheld(const std::string& given, const fs::path& data_folder) {
  if (!given.empty()) return given;
  std::error_code error;
  for (const fs::path& file : {fs::path("configs/withheld_models.yaml"),
                               data_folder / "withheld_models.yaml",
                               stages::InstalledFolder() / "configs" / "withheld_models.yaml"}) {
    if (fs::exists(file, error)) return file.string();
  }
  return {};
}

int BuildLibrary(const LibraryArguments& arguments) {
  const fs::path data_folder = stages::FindDataFolder(arguments.data);
  const fs::path out = arguments.out.empty() ? data_folder / "library" : fs::path(arguments.out);
  const Result<std::vector<std::string>> withheld =
      Withheld(DefaultWithheld(arguments.withheld, data_folder));
  if (!withheld.ok()) return ReportError(withheld.error());
  const Result<std::string> source = SourceHash(arguments, *withheld);
  if (!source.ok()) {
    return ReportError(InvalidInput(
        source.error().message +
        "; install the package sweethome3d-furniture (scripts/setup.sh does), or name the "
        "folder with --catalogues"));
  }
  const fs::path stamp = out.string() + std::string(kSourceStamp);
  const Result<std::string> made_from = storage::ReadFile(stamp);
  if (!arguments.force && made_from.ok() && *made_from == *source &&
      library::LoadLibrary(out).ok()) {
    LogInfo(fmt::format("{} is up to date", out.string()));
    return kExitOk;
  }
  if (Status status = storage::MakeFolders(out.parent_path()); !status.ok())
    return ReportError(status.error());
  CatchStopSignals();
  ConsoleListener listener(ParseProgressStyle("auto"), false);
  listener.StageStarts("library", {});
  const auto start = std::chrono::steady_clock::now();
  const Result<library::LibrarySummary> summary =
      library::BuildLibrary({arguments.catalogues, out, *withheld}, listener);
  if (!summary.ok()) return ReportError(summary.error());
  std::string line;
  int total = 0;
  for (const auto& [class_name, count] : summary->per_class) {
    line += fmt::format(", {} {}", count, class_name);
    total += count;
  }
  listener.StageDone(
      "library",
      fmt::format("{} models of {} catalogue items{}", total, summary->num_catalogue_items, line),
      {SecondsSince(start), 0, 0});
  if (Status status = storage::WriteFileAtomically(stamp, *source); !status.ok())
    return ReportError(status.error());
  return kExitOk;
}

int SplitLibrary(const std::string& catalogues, double share) {
  CatchStopSignals();
  ConsoleListener listener(ParseProgressStyle("auto"), false);
  listener.StageStarts("split", {});
  const auto start = std::chrono::steady_clock::now();
  const Result<std::vector<library::WithheldProduct>> withheld =
      library::ChooseWithheld(catalogues, share, listener);
  if (!withheld.ok()) return ReportError(withheld.error());
  listener.StageDone(
      "split", fmt::format("{} products withheld", withheld->size()), {SecondsSince(start), 0, 0});
  std::fputs(library::WithheldYaml(*withheld).c_str(), stdout);
  return kExitOk;
}

}  // namespace

void AddLibrary(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<LibraryArguments>();
  CLI::App* library_command =
      app.add_subcommand("library", "The furniture library of CAD proposals");
  library_command->require_subcommand(1);
  CLI::App* build = library_command->add_subcommand(
      "build", "Make it from furniture catalogues; quick when up to date");
  build
      ->add_option("--catalogues", arguments->catalogues, "Folder with *.sh3f furniture catalogues")
      ->capture_default_str();
  build->add_option(
      "-o,--output", arguments->out, "Library folder (default: `library` in the data folder)");
  build->add_option("--withheld", arguments->withheld, "YAML list of products to leave out");
  build->add_option("--data", arguments->data, "Data folder");
  build->add_flag("--force", arguments->force, "Make it although it is up to date");
  build->callback(
      [&chosen, arguments] { chosen = [arguments] { return BuildLibrary(*arguments); }; });

  struct SplitArguments {
    std::string catalogues = kCatalogueFolder;
    double share = 0.25;
  };
  auto split_arguments = std::make_shared<SplitArguments>();
  CLI::App* split = library_command->add_subcommand(
      "split", "Choose products to withhold from library and training; prints the list");
  split
      ->add_option(
          "--catalogues", split_arguments->catalogues, "Folder with *.sh3f furniture catalogues")
      ->capture_default_str();
  split->add_option("--share", split_arguments->share, "Of each class's products")
      ->check(NumberFrom(0.0, 1.0))
      ->capture_default_str();
  split->callback([&chosen, split_arguments] {
    chosen = [split_arguments] {
      return SplitLibrary(split_arguments->catalogues, split_arguments->share);
    };
  });
}

}  // namespace deepslam::tools
