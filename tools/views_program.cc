// `deepslam-views`: renders training views of products that were packed and of designs made up by
// rules, and nothing else. It needs few libraries, so that it can be carried to a machine that has
// none of ours (scripts/train/gpu.sh).
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include "deepslam/core/parallel.h"
#include "packed_products.h"
#include "render_options.h"
#include "render_shards.h"
#include "training_models.h"

namespace {

using namespace deepslam;         // NOLINT(google-build-using-namespace)
using namespace deepslam::tools;  // NOLINT(google-build-using-namespace)

struct Arguments {
  TrainingModelRequest models;
  RenderRequest render;
  std::string pack;
  std::string out;
  int threads = 0;
};

Result<RenderTotals> Render(const Arguments& arguments) {
  std::optional<ThreadLimit> limit;
  if (arguments.threads > 0) limit.emplace(arguments.threads);
  Result<TrainingProducts> products = ReadPack(arguments.pack);
  if (!products) return products.error();
  const TrainingModels models = TrainingModels::Of(arguments.models, std::move(*products));
  if (models.size() == 0)
    return InvalidConfig("no model to render: --designs 0, and no product in the pack");
  SilentProgress progress;
  return RenderShards(arguments.render, models, arguments.out, progress);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Training views of packed products and designs made up by rules"};
  Arguments arguments;
  app.add_option("-o,--output", arguments.out, "Folder of .npy arrays to make")->required();
  app.add_option("--pack", arguments.pack, "File of `deepslam priors pack`")->required();
  AddClassOption(app, arguments.models.classes);
  AddModelOptions(app, arguments.models);
  AddViewOptions(app, arguments.render);
  app.add_option("--threads", arguments.threads, "0: all cores; views do not depend on it")
      ->check(CLI::Range(0, 1024));
  CLI11_PARSE(app, argc, argv);
  arguments.models.seed = arguments.render.seed;
  const Result<RenderTotals> totals = Render(arguments);
  if (!totals) {
    std::fprintf(stderr, "error: %s\n", totals.error().message.c_str());
    return 1;
  }
  std::printf("%zu views of %zu models\n", totals->views, totals->models);
  return 0;
}
