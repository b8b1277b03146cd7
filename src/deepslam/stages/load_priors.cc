#include "deepslam/stages/load_priors.h"

#include <array>
#include <memory>
#include <string>
#include <utility>

#include "deepslam/propose/shape_prior.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/storage/store.h"

namespace deepslam::stages {

Result<propose::ShapePriors> LoadPriors(const std::filesystem::path& folder,
                                        const ClassTable& classes) {
  propose::ShapePriors priors;
  for (const ObjectClass& object_class : classes.classes) {
    const std::filesystem::path of_class = folder / object_class.name;
    std::error_code code;
    if (!std::filesystem::is_directory(of_class, code)) continue;
    std::array<std::string, 3> networks;
    constexpr std::array kFiles = {"sketch.onnx", "encoder.onnx", "decoder.onnx"};
    for (std::size_t n = 0; n < kFiles.size(); ++n) {
      Result<std::string> bytes = storage::ReadFile(of_class / kFiles.at(n));
      if (!bytes.ok()) return bytes.error();
      networks.at(n) = std::move(bytes).value();
    }
    Result<std::unique_ptr<propose::ShapePrior>> prior =
        propose::ShapePrior::Load(object_class.name, networks[0], networks[1], networks[2]);
    if (!prior.ok())
      return Error{prior.error().code, of_class.string() + "/" + prior.error().message};
    priors.emplace(object_class.name, std::move(prior).value());
  }
  if (priors.empty())
    return InvalidInput(
        folder.string() +
        ": holds no networks of any class; expected CLASS/sketch.onnx, encoder.onnx, "
        "decoder.onnx, as scripts/train/train.sh makes them");
  return priors;
}

Result<std::shared_ptr<const propose::ShapePriors>> PriorsOf(const RunInputs& inputs) {
  const auto folder = FindPriors(inputs.data_folder, inputs.config.propose_stage.priors);
  if (!folder.ok()) return folder.error();
  if (!*folder) return std::shared_ptr<const propose::ShapePriors>();
  if (inputs.models) return inputs.models->Priors(**folder, inputs.classes);
  Result<propose::ShapePriors> priors = LoadPriors(**folder, inputs.classes);
  if (!priors.ok()) return priors.error();
  return std::make_shared<const propose::ShapePriors>(std::move(priors).value());
}

}  // namespace deepslam::stages
