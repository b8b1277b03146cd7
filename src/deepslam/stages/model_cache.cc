#include "deepslam/stages/model_cache.h"

#include <utility>

#include <fmt/format.h>

#include "deepslam/library/furniture_library.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/stages/content_hashes.h"
#include "deepslam/stages/load_priors.h"
#include "deepslam/storage/mapped_file.h"

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

}  // namespace deepslam::stages
