#include "deepslam/stages/model_cache.h"

#include <algorithm>
#include <array>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
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

Result<std::unique_ptr<propose::ShapePrior>> LoadPrior(const fs::path& folder,
                                                       const std::string& class_name) {
  std::array<std::string, 3> networks;
  constexpr std::array kFiles = {"sketch.onnx", "encoder.onnx", "decoder.onnx"};
  for (std::size_t n = 0; n < kFiles.size(); ++n) {
    Result<std::string> bytes = storage::ReadFile(folder / kFiles.at(n));
    if (!bytes.ok()) return bytes.error();
    networks.at(n) = std::move(bytes).value();
  }
  Result<std::unique_ptr<propose::ShapePrior>> prior =
      propose::ShapePrior::Load(class_name, networks[0], networks[1], networks[2]);
  if (!prior.ok()) return Error{prior.error().code, folder.string() + "/" + prior.error().message};
  return prior;
}

// Of those of the classes that have a folder, opened side by side.
Result<propose::ShapePriors> LoadPriors(const fs::path& folder,
                                        const std::set<std::string>& classes) {
  std::vector<std::string> there;
  for (const std::string& name : classes) {
    std::error_code code;
    if (fs::is_directory(folder / name, code)) there.push_back(name);
  }
  // Opening networks is what takes time, and each is opened by one thread.
  std::vector<std::optional<Result<std::unique_ptr<propose::ShapePrior>>>> loaded(there.size());
  ParallelFor(there.size(),
              [&](std::size_t n) { loaded[n] = LoadPrior(folder / there[n], there[n]); });
  propose::ShapePriors priors;
  for (std::size_t n = 0; n < there.size(); ++n) {
    if (!loaded[n]->ok()) return loaded[n]->error();
    priors.emplace(there[n], std::move(**loaded[n]));
  }
  return priors;
}

std::set<std::string> NamesOf(const ClassTable& classes) {
  std::set<std::string> names;
  for (const ObjectClass& object_class : classes.classes) names.insert(object_class.name);
  return names;
}

Status CheckHoldsNetworks(const fs::path& folder, const ClassTable& classes) {
  const auto has_folder = [&](const ObjectClass& object_class) {
    std::error_code code;
    return fs::is_directory(folder / object_class.name, code);
  };
  if (std::ranges::any_of(classes.classes, has_folder)) return Ok();
  return InvalidInput(folder.string() +
                      ": holds no networks of any class; expected CLASS/sketch.onnx, encoder.onnx, "
                      "decoder.onnx, as scripts/train/train.sh makes them");
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

Result<propose::ShapePriors> ModelCache::Priors(const fs::path& folder,
                                                const std::set<std::string>& classes) {
  const std::string source = StateOf(folder);
  if (priors_source_ != source) priors_.clear();
  priors_source_ = source;
  std::set<std::string> missing;
  for (const std::string& name : classes) {
    if (!priors_.contains(name)) missing.insert(name);
  }
  Result<propose::ShapePriors> loaded = LoadPriors(folder, missing);
  if (!loaded.ok()) return loaded.error();
  priors_.merge(*loaded);
  propose::ShapePriors wanted;
  for (const auto& [name, prior] : priors_) {
    if (classes.contains(name)) wanted.emplace(name, prior);
  }
  return wanted;
}

Result<std::shared_ptr<const propose::ShapePriors>> FindShapePriors(
    const ModelFolders& folders,
    const std::string& named,
    const ClassTable& classes,
    const std::optional<std::set<std::string>>& only) {
  const auto folder = FindPriors(folders.data_folder, named);
  if (!folder.ok()) return folder.error();
  if (!*folder) return std::shared_ptr<const propose::ShapePriors>();
  if (Status status = CheckHoldsNetworks(**folder, classes); !status.ok()) return status.error();
  std::set<std::string> wanted = NamesOf(classes);
  if (only) std::erase_if(wanted, [&](const std::string& name) { return !only->contains(name); });
  Result<propose::ShapePriors> priors =
      folders.cache ? folders.cache->Priors(**folder, wanted) : LoadPriors(**folder, wanted);
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
