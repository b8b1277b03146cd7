// Products that were packed to be carried (priors/model_pack.h).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "training_products.h"

namespace deepslam::tools {

struct PackTotals {
  std::size_t models = 0;
  std::size_t withheld = 0;  // of those
  std::size_t bytes = 0;
};

// Reads the products' meshes and writes them as one file. Withheld products of `classes` go along,
// marked, so that the networks can be scored where they are trained; what cannot be read is left
// out with a warning.
[[nodiscard]] Result<PackTotals> WritePack(const TrainingProducts& products,
                                           const std::vector<std::string>& classes,
                                           const std::filesystem::path& file,
                                           Progress& progress);

[[nodiscard]] Result<TrainingProducts> ReadPack(const std::filesystem::path& file);

}  // namespace deepslam::tools
