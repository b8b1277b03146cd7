// Training views of many models, rendered side by side and written to disk in order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/priors/training_view.h"
#include "training_models.h"

namespace deepslam::tools {

struct RenderRequest {
  std::uint64_t seed = 1;
  int views = 24;          // of each generated design
  int product_views = 48;  // of each product and mesh, and of what is made of it
  bool clean = false;      // whole objects, without faults of sensor and mask
  double tops = 0;         // share of views of which only what lies above some height is left
};

struct RenderedModel {
  TrainingModel model;
  std::vector<priors::TrainingView> views;
};

// Model `n` with its views; a view depends on seed, model and its number alone.
[[nodiscard]] Result<RenderedModel> RenderModel(const RenderRequest& request,
                                                const TrainingModels& models,
                                                std::size_t n);

struct RenderTotals {
  std::size_t models = 0;
  std::size_t views = 0;
};

// All models into folder `out` (training_shards.h).
[[nodiscard]] Result<RenderTotals> RenderShards(const RenderRequest& request,
                                                const TrainingModels& models,
                                                const std::filesystem::path& out,
                                                Progress& progress);

}  // namespace deepslam::tools
