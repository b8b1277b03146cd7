#include "render_shards.h"

#include <array>
#include <optional>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/core/parallel_ahead.h"
#include "deepslam/core/random.h"
#include "training_shards.h"

namespace deepslam::tools {
namespace {

std::size_t NumViews(const RenderRequest& request, const TrainingModels& models, std::size_t n) {
  return static_cast<std::size_t>(models.IsProduct(n) ? request.product_views : request.views);
}

Status AddRendered(const RenderedModel& rendered, TrainingShards& shards) {
  if (Status status = shards.AddModel(rendered.model); !status) return status;
  for (const priors::TrainingView& view : rendered.views) {
    if (Status status = shards.AddView(view); !status) return status;
  }
  return Ok();
}

}  // namespace

Result<RenderedModel> RenderModel(const RenderRequest& request,
                                  const TrainingModels& models,
                                  std::size_t n) {
  Result<TrainingModel> model = models.Make(n);
  if (!model) return model.error();
  // What is written of a model besides its views does not need the mesh any more.
  const Result<priors::ViewRenderer> renderer =
      priors::ViewRenderer::Make(std::exchange(model->furniture, {}));
  if (!renderer) return InvalidInput(model->id + ": " + renderer.error().message);
  RenderedModel rendered{std::move(*model), {}};
  rendered.views.resize(NumViews(request, models, n));
  const priors::ViewOptions options{!request.clean, request.tops};
  ParallelFor(rendered.views.size(), [&](std::size_t v) {
    rendered.views[v] =
        renderer->Render(Random(request.seed, rendered.model.id + " view", v), options);
  });
  return rendered;
}

Result<RenderTotals> RenderShards(const RenderRequest& request,
                                  const TrainingModels& models,
                                  const std::filesystem::path& out,
                                  Progress& progress) {
  RenderTotals totals{models.size(), 0};
  for (std::size_t n = 0; n < models.size(); ++n) totals.views += NumViews(request, models, n);
  Result<TrainingShards> shards = TrainingShards::Create(out, totals.models, totals.views);
  if (!shards) return shards.error();
  // Models rendered while earlier ones are written, each held in memory.
  constexpr std::size_t kAhead = 8;
  std::array<std::optional<Result<RenderedModel>>, kAhead> ahead;
  Status status = Ok();
  const auto prepare = [&](std::size_t n) { ahead[n % kAhead] = RenderModel(request, models, n); };
  const auto write = [&](std::size_t n) {
    const Result<RenderedModel> rendered = *std::exchange(ahead[n % kAhead], std::nullopt);
    if (progress.StopRequested()) {
      status = Interrupted();
    } else {
      status = rendered ? AddRendered(*rendered, *shards) : Status(rendered.error());
    }
    progress.Report(n + 1, models.size());
    return status.ok();
  };
  ParallelAhead(models.size(), kAhead, prepare, write);
  if (!status) return status.error();
  status = shards->Finish(request.seed, !request.clean);
  if (!status) return status.error();
  return totals;
}

}  // namespace deepslam::tools
