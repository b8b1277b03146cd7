#include "deepslam/stages/model_cache.h"

#include <array>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "deepslam/library/furniture_library.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/propose/shape_prior.h"
#include "deepslam/stages/content_hashes.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/storage/mapped_file.h"
#include "deepslam/storage/store.h"

namespace deepslam::stages {
namespace {

namespace fs = std::filesystem;

std::string OptionsText(detect::DetectorOptions options) {
  std::string text = fmt::format("{} threads, images of {}x{}",
                                 options.num_threads,
                                 options.images.width,
                                 options.images.height);
  const pipeline::OptionSection section{
      "network", "", [&](OptionsVisitor& visitor) { Describe(visitor, options); }};
  for (const auto& [name, value] : pipeline::OptionValues(section))
    text += " " + name + "=" + value;
  return text;
}

}  // namespace

Result<std::unique_ptr<detect::Detector>> LoadDetectorFile(const fs::path& onnx_file,
                                                           const detect::DetectorOptions& options) {
  const Result<storage::MappedFile> file = storage::MappedFile::Open(onnx_file);
  if (!file.ok()) return file.error();
  Result<std::unique_ptr<detect::Detector>> detector =
      detect::LoadNetworkDetector(file->bytes(), options);
  if (!detector.ok())
    return Error{detector.error().code,
                 fmt::format("{}: {}", onnx_file.string(), detector.error().message)};
  return detector;
}

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

Result<std::shared_ptr<const detect::Detector>> ModelCache::Detector(
    const fs::path& onnx_file, const detect::DetectorOptions& options) {
  const std::string source = StateOf(onnx_file) + OptionsText(options);
  if (detector_.value && detector_.source == source) return detector_.value;
  detector_ = {};  // before the new one: never two in memory
  Result<std::unique_ptr<detect::Detector>> loaded = LoadDetectorFile(onnx_file, options);
  if (!loaded.ok()) return loaded.error();
  detector_ = {source, std::move(loaded).value()};
  return detector_.value;
}

Result<std::shared_ptr<const ModelLibrary>> ModelCache::Library(const fs::path& folder) {
  const std::string source = StateOf(folder);
  if (library_.value && library_.source == source) return library_.value;
  library_ = {};
  Result<ModelLibrary> loaded = library::LoadLibrary(folder);
  if (!loaded.ok()) return loaded.error();
  library_ = {source, std::make_shared<const ModelLibrary>(std::move(loaded).value())};
  return library_.value;
}

Result<std::shared_ptr<const propose::ShapePriors>> ModelCache::Priors(const fs::path& folder,
                                                                       const ClassTable& classes) {
  std::string source = StateOf(folder);
  for (const ObjectClass& object_class : classes.classes) source += object_class.name + '\n';
  if (priors_.value && priors_.source == source) return priors_.value;
  priors_ = {};
  Result<propose::ShapePriors> loaded = LoadPriors(folder, classes);
  if (!loaded.ok()) return loaded.error();
  priors_ = {source, std::make_shared<const propose::ShapePriors>(std::move(loaded).value())};
  return priors_.value;
}

Result<std::shared_ptr<const propose::ShapePriors>> FindShapePriors(const ModelFolders& folders,
                                                                    const std::string& named,
                                                                    const ClassTable& classes) {
  const auto folder = FindPriors(folders.data_folder, named);
  if (!folder.ok()) return folder.error();
  if (!*folder) return std::shared_ptr<const propose::ShapePriors>();
  if (folders.cache) return folders.cache->Priors(**folder, classes);
  Result<propose::ShapePriors> priors = LoadPriors(**folder, classes);
  if (!priors.ok()) return priors.error();
  return std::make_shared<const propose::ShapePriors>(std::move(priors).value());
}

Result<std::shared_ptr<const ModelLibrary>> FindModelLibrary(const ModelFolders& folders,
                                                             const std::string& named) {
  const Result<fs::path> folder = FindLibrary(folders.data_folder, named);
  if (!folder.ok()) return folder.error();
  if (folders.cache) return folders.cache->Library(*folder);
  Result<ModelLibrary> library = library::LoadLibrary(*folder);
  if (!library.ok()) return library.error();
  return std::make_shared<const ModelLibrary>(std::move(library).value());
}

}  // namespace deepslam::stages
