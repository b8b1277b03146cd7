#include "packed_products.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/priors/model_pack.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {

Result<PackTotals> WritePack(const TrainingProducts& products,
                             const std::vector<std::string>& classes,
                             const std::filesystem::path& file,
                             Progress& progress) {
  std::vector<const TrainingProduct*> taken;
  for (const TrainingProduct& product : products.products) {
    const bool of_class =
        std::find(classes.begin(), classes.end(), product.class_name) != classes.end();
    if (of_class || product.split != "withheld") taken.push_back(&product);
  }
  std::vector<std::optional<Result<TriangleMesh>>> meshes(taken.size());
  ParallelFor(taken.size(), [&](std::size_t n) { meshes[n] = taken[n]->read(); });
  priors::ModelPack pack;
  pack.withheld = products.withheld;
  PackTotals totals;
  for (std::size_t n = 0; n < taken.size(); ++n) {
    const TrainingProduct& product = *taken[n];
    if (!meshes[n]->ok()) {
      progress.Warn(product.id + ": " + meshes[n]->error().message);
      continue;
    }
    pack.models.push_back({product.id,
                           product.class_name,
                           product.source,
                           product.split,
                           product.credit,
                           product.between_arms,
                           std::move(**meshes[n])});
    if (product.split == "withheld") ++totals.withheld;
  }
  const Result<std::string> bytes = priors::EncodeModelPack(pack);
  if (!bytes) return bytes.error();
  if (Status status = storage::WriteFileAtomically(file, *bytes); !status) return status.error();
  totals.models = pack.models.size();
  totals.bytes = bytes->size();
  return totals;
}

Result<TrainingProducts> ReadPack(const std::filesystem::path& file) {
  const Result<std::string> bytes = storage::ReadFile(file);
  if (!bytes) return bytes.error();
  Result<priors::ModelPack> pack = priors::DecodeModelPack(*bytes);
  if (!pack) return InvalidInput(file.string() + ": " + pack.error().message);
  TrainingProducts products;
  products.withheld = std::move(pack->withheld);
  for (priors::PackedModel& model : pack->models) {
    TrainingProduct product;
    product.id = std::move(model.id);
    product.class_name = std::move(model.class_name);
    product.source = std::move(model.source);
    product.split = std::move(model.split);
    product.credit = std::move(model.credit);
    product.between_arms = model.between_arms;
    const auto mesh = std::make_shared<const TriangleMesh>(std::move(model.mesh));
    product.read = [mesh]() -> Result<TriangleMesh> { return *mesh; };
    products.products.push_back(std::move(product));
  }
  return products;
}

}  // namespace deepslam::tools
