#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "catalogues.h"
#include "commands.h"
#include "console.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/parallel_ahead.h"
#include "deepslam/core/random.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/furniture/design.h"
#include "deepslam/priors/contact_sheet.h"
#include "deepslam/priors/training_view.h"
#include "priors_look.h"
#include "synth_capture.h"
#include "training_models.h"
#include "training_shards.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

struct RenderArguments {
  TrainingModelRequest models;
  fs::path out;
  fs::path sheet;
  int views = 24;
  int product_views = 48;
  int threads = 0;
  bool clean = false;
  double tops = 0;
  int sheet_rows = 24;
};

struct Rendered {
  std::optional<Result<TrainingModel>> model;
  std::optional<Result<priors::ViewRenderer>> renderer;
  std::vector<priors::TrainingView> views;
};

int ViewsOf(const RenderArguments& arguments, const TrainingModels& models, std::size_t n) {
  return models.IsProduct(n) ? arguments.product_views : arguments.views;
}

// Model `n` with its views; a view depends on seed, model and its number alone.
Rendered RenderModel(const RenderArguments& arguments,
                     const TrainingModels& models,
                     std::size_t n) {
  Rendered rendered;
  rendered.model = models.Make(n);
  if (!rendered.model->ok()) return rendered;
  const TrainingModel& model = **rendered.model;
  rendered.renderer = priors::ViewRenderer::Make(model.furniture);
  if (!rendered.renderer->ok()) return rendered;
  rendered.views.resize(static_cast<std::size_t>(ViewsOf(arguments, models, n)));
  const priors::ViewOptions options{!arguments.clean, arguments.tops};
  ParallelFor(rendered.views.size(), [&](std::size_t v) {
    rendered.views[v] =
        (**rendered.renderer).Render(Random(arguments.models.seed, model.id + " view", v), options);
  });
  return rendered;
}

Status CheckRendered(const Rendered& rendered) {
  if (!rendered.model->ok()) return rendered.model->error();
  if (!rendered.renderer->ok()) {
    return InvalidInput((**rendered.model).id + ": " + rendered.renderer->error().message);
  }
  return Ok();
}

Status AddRendered(const Rendered& rendered, TrainingShards& shards) {
  if (Status status = CheckRendered(rendered); !status.ok()) return status;
  if (Status status = shards.AddModel(**rendered.model); !status.ok()) return status;
  for (const priors::TrainingView& view : rendered.views) {
    if (Status status = shards.AddView(view); !status.ok()) return status;
  }
  return Ok();
}

struct Totals {
  std::size_t models = 0;
  std::size_t views = 0;
};

Result<Totals> RenderShards(const RenderArguments& arguments,
                            const TrainingModels& models,
                            Progress& progress) {
  Totals totals{models.size(), 0};
  for (std::size_t n = 0; n < models.size(); ++n)
    totals.views += static_cast<std::size_t>(ViewsOf(arguments, models, n));
  Result<TrainingShards> shards =
      TrainingShards::Create(arguments.out, totals.models, totals.views);
  if (!shards) return shards.error();
  constexpr std::size_t kAhead = 8;
  std::array<Rendered, kAhead> ahead;
  Status status = Ok();
  const auto prepare = [&](std::size_t n) {
    ahead[n % kAhead] = RenderModel(arguments, models, n);
  };
  const auto write = [&](std::size_t n) {
    const Rendered rendered = std::exchange(ahead[n % kAhead], {});
    status = progress.StopRequested() ? Interrupted() : AddRendered(rendered, *shards);
    progress.Report(n + 1, models.size());
    return status.ok();
  };
  ParallelAhead(models.size(), kAhead, prepare, write);
  if (!status) return status.error();
  status = shards->Finish(arguments.models.seed, !arguments.clean);
  if (!status) return status.error();
  return totals;
}

// A few views of models spread over the list.
Result<Totals> RenderSheet(const RenderArguments& arguments, const TrainingModels& models) {
  RenderArguments few = arguments;
  few.views = few.product_views = 6;
  std::vector<priors::SheetRow> rows;
  const auto wanted = std::min(static_cast<std::size_t>(arguments.sheet_rows), models.size());
  for (std::size_t row = 0; row < wanted; ++row) {
    Rendered one = RenderModel(few, models, row * models.size() / wanted);
    if (const Status status = CheckRendered(one); !status) return status.error();
    rows.push_back({std::move(one.views), (**one.model).shape});
  }
  const Status written = dataset::WriteColourFile(arguments.sheet, priors::DrawContactSheet(rows));
  if (!written) return written.error();
  return Totals{rows.size(), rows.size() * 6};
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
  const Result<TrainingModels> models = TrainingModels::List(arguments.models, listener);
  if (!models) return ReportError(models.error());
  for (const std::string& line : models->dropped()) LogWarning(line);
  if (models->size() == 0) {
    return ReportError(
        InvalidConfig("no model to render: --designs 0, and no product of the classes asked for"));
  }
  listener.StageDone("models", fmt::format("{} models", models->size()), {seconds(), 0, 0});
  listener.StageStarts("render", {});
  start = std::chrono::steady_clock::now();
  const Result<Totals> totals = arguments.sheet.empty() ? RenderShards(arguments, *models, listener)
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

}  // namespace

void AddPriors(CLI::App& app, Command& chosen) {
  CLI::App* priors = app.add_subcommand(
      "priors",
      "Training data of the shape networks (scripts/train), and a look at what they propose");
  priors->require_subcommand(1);
  AddPriorsLook(*priors, chosen);
  auto arguments = std::make_shared<RenderArguments>();
  TrainingModelRequest& models = arguments->models;
  models.classes = {"chair"};
  models.num_designs = 1500;
  models.catalogues = kCatalogueFolder;
  models.withheld_list = "configs/withheld_models.yaml";
  models.num_variants = 2;
  CLI::App* render = priors->add_subcommand(
      "render", "Render views of generated designs, catalogue products and meshes of yours");
  render->add_option("-o,--output", arguments->out, "Folder of .npy arrays to make");
  render->add_option("--sheet", arguments->sheet, "Instead: a contact sheet (PNG) to look at");
  render->add_option("--rows", arguments->sheet_rows, "Models on the contact sheet")
      ->check(CLI::Range(1, 200))
      ->capture_default_str();
  render->add_option("--class", models.classes, "Class of the map; may be given again")
      ->check(CLI::IsMember({"chair", "table", "sofa", "bed", "cabinet", "shelf"}))
      ->capture_default_str();
  render->add_option("--designs", models.num_designs, "Generated designs of each class")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  render->add_option("--first-design", models.first_design, "Number of the first of them")
      ->check(CLI::Range(0, 100'000'000))
      ->capture_default_str();
  render->add_option("--views", arguments->views, "Views of each generated design")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  render->add_option("--product-views", arguments->product_views, "Views of each product and mesh")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  render
      ->add_option("--variants",
                   models.num_variants,
                   "Variants of products and meshes: other proportions, other backs")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  render
      ->add_option("--widened",
                   models.num_widened,
                   "Sofas made of each armchair, which becomes as wide: other sofas to learn from")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  render
      ->add_option(
          "--narrowed",
          models.num_narrowed,
          "Armchairs made of each sofa, which becomes as narrow: other chairs to learn from")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  render->add_flag_callback(
      "--no-catalogue",
      [arguments] { arguments->models.catalogue = false; },
      "Leave the catalogues' products out");
  render->add_option("--catalogues", models.catalogues, "Folder with *.sh3f furniture catalogues")
      ->capture_default_str();
  render
      ->add_option(
          "--withheld-list", models.withheld_list, "YAML list of products never to train on")
      ->capture_default_str();
  render->add_flag(
      "--withheld",
      models.withheld,
      "The withheld products instead, and nothing else: for tests, never for training");
  render
      ->add_option(
          "--meshes",
          models.mesh_folders,
          "Folder with furniture of yours, CLASS/NAME.obj (.glb, .gltf; y up, z front); may "
          "be given again")
      ->allow_extra_args(false);
  render->add_flag("--clean", arguments->clean, "Whole objects, without faults of sensor and mask");
  render
      ->add_option(
          "--tops",
          arguments->tops,
          "Share of the views of which only what lies above some height is left, cut by the "
          "image: tables seen from close by")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  render->add_option("--seed", models.seed, "Of designs and views")->capture_default_str();
  render->add_option("--threads", arguments->threads, "0: all cores; views do not depend on it")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  render->callback([&chosen, arguments] { chosen = [arguments] { return Render(*arguments); }; });
}

}  // namespace deepslam::tools
