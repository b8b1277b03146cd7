#include "deepslam/stages/model_cache.h"

#include <sys/stat.h>

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/store.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/stages/load_priors.h"

namespace deepslam::stages {
namespace {

namespace fs = std::filesystem;

std::string FileState(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return "missing";
  return fmt::format("{} {}:{} {} {}.{} {}.{}",
                     file.string(),
                     status.st_dev,
                     status.st_ino,
                     status.st_size,
                     status.st_mtim.tv_sec,
                     status.st_mtim.tv_nsec,
                     status.st_ctim.tv_sec,
                     status.st_ctim.tv_nsec);
}

// What a file, or all files below a folder, look like from outside.
std::string State(const fs::path& file_or_folder) {
  std::error_code error;
  if (!fs::is_directory(file_or_folder, error)) return FileState(file_or_folder);
  std::vector<std::string> states;
  for (fs::recursive_directory_iterator it(file_or_folder, error), end; !error && it != end;
       it.increment(error)) {
    states.push_back(FileState(it->path()));
  }
  std::sort(states.begin(), states.end());
  std::string all;
  for (const std::string& state : states) all += state + '\n';
  return all;
}

std::string OptionsText(detect::DetectorOptions options) {
  std::string text = fmt::format("{} threads", options.num_threads);
  const pipeline::OptionSection section{
      "network", "", [&](OptionsVisitor& visitor) { Describe(visitor, options); }};
  for (const auto& [name, value] : pipeline::OptionValues(section))
    text += " " + name + "=" + value;
  return text;
}

}  // namespace

Result<std::unique_ptr<detect::Detector>> LoadDetectorFile(const fs::path& onnx_file,
                                                           const detect::DetectorOptions& options) {
  const Result<std::string> bytes = artifact::ReadFile(onnx_file);
  if (!bytes.ok()) return bytes.error();
  Result<std::unique_ptr<detect::Detector>> detector = detect::LoadNetworkDetector(*bytes, options);
  if (!detector.ok())
    return Error{detector.error().code,
                 fmt::format("{}: {}", onnx_file.string(), detector.error().message)};
  return detector;
}

Result<std::string> ModelCache::Hash(const fs::path& file_or_folder) {
  const std::string state = State(file_or_folder);
  HeldHash& held = hashes_[file_or_folder];
  if (held.state == state && !held.hash.empty()) return held.hash;
  std::error_code error;
  Result<std::string> hash = fs::is_directory(file_or_folder, error)
                                 ? artifact::HashFolder(file_or_folder)
                                 : artifact::HashFile(file_or_folder);
  if (hash.ok()) held = {state, *hash};
  return hash;
}

Result<std::shared_ptr<const detect::Detector>> ModelCache::Detector(
    const fs::path& onnx_file, const detect::DetectorOptions& options) {
  const std::string source = State(onnx_file) + OptionsText(options);
  if (detector_.value && detector_.source == source) return detector_.value;
  detector_ = {};  // before the new one: never two in memory
  Result<std::unique_ptr<detect::Detector>> loaded = LoadDetectorFile(onnx_file, options);
  if (!loaded.ok()) return loaded.error();
  detector_ = {source, std::move(loaded).value()};
  return detector_.value;
}

Result<std::shared_ptr<const ModelLibrary>> ModelCache::Library(const fs::path& folder) {
  const std::string source = State(folder);
  if (library_.value && library_.source == source) return library_.value;
  library_ = {};
  Result<ModelLibrary> loaded = library::LoadLibrary(folder);
  if (!loaded.ok()) return loaded.error();
  library_ = {source, std::make_shared<const ModelLibrary>(std::move(loaded).value())};
  return library_.value;
}

Result<std::shared_ptr<const propose::ShapePriors>> ModelCache::Priors(const fs::path& folder,
                                                                       const ClassTable& classes) {
  std::string source = State(folder);
  for (const ObjectClass& object_class : classes.classes) source += object_class.name + '\n';
  if (priors_.value && priors_.source == source) return priors_.value;
  priors_ = {};
  Result<propose::ShapePriors> loaded = LoadPriors(folder, classes);
  if (!loaded.ok()) return loaded.error();
  priors_ = {source, std::make_shared<const propose::ShapePriors>(std::move(loaded).value())};
  return priors_.value;
}

}  // namespace deepslam::stages
