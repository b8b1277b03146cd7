#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "catalogue_products.h"
#include "catalogues.h"
#include "commands.h"
#include "console.h"
#include "deepslam/core/parallel.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/priors/contact_sheet.h"
#include "packed_products.h"
#include "priors_look.h"
#include "render_options.h"
#include "render_shards.h"
#include "training_models.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

struct RenderArguments {
  TrainingModelRequest models;
  ProductRequest products;
  RenderRequest render;
  fs::path pack;  // read in place of catalogues and folders
  fs::path out;
  fs::path sheet;
  int threads = 0;
  int sheet_rows = 24;
};

struct PackArguments {
  std::vector<std::string> classes = {"chair"};
  ProductRequest products;
  fs::path out;
};

Result<TrainingModels> ListModels(const RenderArguments& arguments, Progress& progress) {
  ProductRequest request = arguments.products;
  request.classes = ClassesToRead(arguments.models);
  request.catalogue = request.catalogue || arguments.models.withheld;
  if (arguments.models.withheld) request.mesh_folders.clear();
  if (!arguments.pack.empty()) {
    Result<TrainingProducts> products = ReadPack(arguments.pack);
    if (!products) return products.error();
    return TrainingModels::Of(arguments.models, std::move(*products));
  }
  // Without the withheld products nothing tells whether a folder's mesh is one of them.
  if (!request.catalogue && request.mesh_folders.empty())
    return TrainingModels::Of(arguments.models, {});
  Result<TrainingProducts> products = ListProducts(request, progress);
  if (!products) return products.error();
  for (const std::string& line : products->dropped) LogWarning(line);
  return TrainingModels::Of(arguments.models, std::move(*products));
}

// A few views of models spread over the list.
Result<RenderTotals> RenderSheet(const RenderArguments& arguments, const TrainingModels& models) {
  RenderRequest few = arguments.render;
  few.views = few.product_views = 6;
  std::vector<priors::SheetRow> rows;
  const auto wanted = std::min(static_cast<std::size_t>(arguments.sheet_rows), models.size());
  for (std::size_t row = 0; row < wanted; ++row) {
    Result<RenderedModel> one = RenderModel(few, models, row * models.size() / wanted);
    if (!one) return one.error();
    rows.push_back({std::move(one->views), std::move(one->model.shape)});
  }
  const Status written = dataset::WriteColourFile(arguments.sheet, priors::DrawContactSheet(rows));
  if (!written) return written.error();
  return RenderTotals{rows.size(), rows.size() * 6};
}

int Render(const RenderArguments& arguments) {
  if (arguments.out.empty() == arguments.sheet.empty())
    return ReportError(
        InvalidConfig("give one of --output (training views) and --sheet (a picture)"));
  std::optional<ThreadLimit> limit;
  if (arguments.threads > 0) limit.emplace(arguments.threads);
  CatchStopSignals();
  ConsoleListener listener(ParseProgressStyle("auto"), false);
  listener.StageStarts("models", {});
  auto start = std::chrono::steady_clock::now();
  const auto seconds = [&start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const Result<TrainingModels> models = ListModels(arguments, listener);
  if (!models) return ReportError(models.error());
  if (models->size() == 0) {
    return ReportError(
        InvalidConfig("no model to render: --designs 0, and no product of the classes asked for"));
  }
  listener.StageDone("models", fmt::format("{} models", models->size()), {seconds(), 0, 0});
  listener.StageStarts("render", {});
  start = std::chrono::steady_clock::now();
  const Result<RenderTotals> totals =
      arguments.sheet.empty() ? RenderShards(arguments.render, *models, arguments.out, listener)
                              : RenderSheet(arguments, *models);
  if (!totals) return ReportError(totals.error());
  const double wall_s = seconds();
  listener.StageDone("render",
                     fmt::format("{} views of {} models, {:.0f} views/s",
                                 totals->views,
                                 totals->models,
                                 static_cast<double>(totals->views) / wall_s),
                     {wall_s, 0, 0});
  return kExitOk;
}

int Pack(const PackArguments& arguments) {
  CatchStopSignals();
  ConsoleListener listener(ParseProgressStyle("auto"), false);
  // Armchairs may be asked to become sofas, and sofas armchairs, where the pack is used.
  TrainingModelRequest models;
  models.classes = arguments.classes;
  models.num_widened = models.num_narrowed = 1;
  ProductRequest request = arguments.products;
  request.classes = ClassesToRead(models);
  const Result<TrainingProducts> products = ListProducts(request, listener);
  if (!products) return ReportError(products.error());
  for (const std::string& line : products->dropped) LogWarning(line);
  const Result<PackTotals> totals =
      WritePack(*products, arguments.classes, arguments.out, listener);
  if (!totals) return ReportError(totals.error());
  listener.EndProgress();
  LogInfo(fmt::format("{}: {} meshes, {} of them withheld, {:.1f} MB before compression",
                      arguments.out.string(),
                      totals->models,
                      totals->withheld,
                      static_cast<double>(totals->bytes) / 1e6));
  return kExitOk;
}

void AddProductOptions(CLI::App& command, ProductRequest& request) {
  request.catalogues = kCatalogueFolder;
  request.withheld_list = "configs/withheld_models.yaml";
  command.add_option("--catalogues", request.catalogues, "Folder with *.sh3f furniture catalogues")
      ->capture_default_str();
  command
      .add_option(
          "--withheld-list", request.withheld_list, "YAML list of products never to train on")
      ->capture_default_str();
  command
      .add_option(
          "--meshes",
          request.mesh_folders,
          "Folder with furniture of yours, CLASS/NAME.obj (.glb, .gltf; y up, z front); may "
          "be given again")
      ->allow_extra_args(false);
}

void AddRenderCommand(CLI::App& priors, Command& chosen) {
  auto arguments = std::make_shared<RenderArguments>();
  arguments->models.classes = {"chair"};
  arguments->models.num_designs = 1500;
  arguments->models.num_variants = 2;
  CLI::App* render = priors.add_subcommand(
      "render", "Render views of generated designs, catalogue products and meshes of yours");
  render->add_option("-o,--output", arguments->out, "Folder of .npy arrays to make");
  render->add_option("--sheet", arguments->sheet, "Instead: a contact sheet (PNG) to look at");
  render->add_option("--rows", arguments->sheet_rows, "Models on the contact sheet")
      ->check(CLI::Range(1, 200))
      ->capture_default_str();
  AddClassOption(*render, arguments->models.classes);
  AddModelOptions(*render, arguments->models);
  render->add_flag_callback(
      "--no-catalogue",
      [arguments] { arguments->products.catalogue = false; },
      "Leave the catalogues' products out");
  AddProductOptions(*render, arguments->products);
  render->add_option(
      "--pack", arguments->pack, "Products out of a file of `priors pack` instead of catalogues");
  AddViewOptions(*render, arguments->render);
  render->add_option("--threads", arguments->threads, "0: all cores; views do not depend on it")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  render->callback([&chosen, arguments] {
    arguments->models.seed = arguments->render.seed;
    chosen = [arguments] { return Render(*arguments); };
  });
}

void AddPackCommand(CLI::App& priors, Command& chosen) {
  auto arguments = std::make_shared<PackArguments>();
  CLI::App* pack = priors.add_subcommand(
      "pack", "Write the products' meshes as one small file, for a machine without catalogues");
  pack->add_option("-o,--output", arguments->out, "File to write")->required();
  AddClassOption(*pack, arguments->classes);
  AddProductOptions(*pack, arguments->products);
  pack->callback([&chosen, arguments] { chosen = [arguments] { return Pack(*arguments); }; });
}

}  // namespace

void AddPriors(CLI::App& app, Command& chosen) {
  CLI::App* priors = app.add_subcommand(
      "priors",
      "Training data of the shape networks (scripts/train), and a look at what they propose");
  priors->require_subcommand(1);
  AddPriorsLook(*priors, chosen);
  AddRenderCommand(*priors, chosen);
  AddPackCommand(*priors, chosen);
}

}  // namespace deepslam::tools
