#include "deepslam/stages/data_folder.h"

#include <cstdlib>

#include <fmt/format.h>

namespace deepslam::stages {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDetectorWithMasks = "yolo11n-seg";
constexpr const char* kDetectorOfBoxes = "yolov8s";

std::string Environment(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace

fs::path InstalledFolder() {
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};
  return executable.parent_path().parent_path() / "share" / "deepslam";
}

fs::path FindDataFolder(const std::string& explicit_folder) {
  if (!explicit_folder.empty()) return explicit_folder;
  if (const std::string folder = Environment("DEEPSLAM_DATA"); !folder.empty()) return folder;
  std::error_code error;
  if (const fs::path installed = InstalledFolder();
      fs::is_directory(installed / "weights", error) ||
      fs::is_directory(installed / "library", error)) {
    return installed;
  }
  if (const std::string xdg = Environment("XDG_DATA_HOME"); !xdg.empty())
    return fs::path(xdg) / "deepslam";
  return fs::path(Environment("HOME")) / ".local" / "share" / "deepslam";
}

Result<fs::path> FindWeights(const fs::path& data_folder, const std::string& weights) {
  const bool is_path = weights.find('/') != std::string::npos || weights.ends_with(".onnx");
  const auto named = [&](const std::string& name) {
    return data_folder / "weights" / (name + ".onnx");
  };
  const fs::path file = is_path
                            ? fs::path(weights)
                            : named(weights.empty() ? std::string(kDetectorWithMasks) : weights);
  std::error_code error;
  if (fs::is_regular_file(file, error)) return file;
  if (const fs::path other = named(kDetectorOfBoxes);
      weights.empty() && fs::is_regular_file(other, error))
    return other;
  return InvalidInput(fmt::format(
      "detect.weights: no file {}; run scripts/setup.sh, or deepslam-fetch-weights of an installed "
      "package, to fetch the weights (`deepslam doctor` shows what is there), "
      "or use --set detect.source=none",
      file.string()));
}

Result<fs::path> FindLibrary(const fs::path& data_folder, const std::string& library) {
  const fs::path folder = library.empty() ? data_folder / "library" : fs::path(library);
  std::error_code error;
  if (fs::is_regular_file(folder / "library.json", error)) return folder;
  return InvalidInput(
      fmt::format("propose.library: no furniture library in {}; make it by "
                  "`deepslam library build` (`deepslam doctor` shows what is there), or use --set "
                  "propose.retrieval=false",
                  folder.string()));
}

Result<std::optional<fs::path>> FindPriors(const fs::path& data_folder, const std::string& priors) {
  std::error_code error;
  if (!priors.empty()) {
    if (fs::is_directory(priors, error)) return std::optional<fs::path>(priors);
    return InvalidInput(fmt::format(
        "propose.priors: no folder {}; make networks by scripts/train/train.sh CLASS, leave the "
        "option "
        "empty for those that came with the program, or use --set propose.network=false",
        priors));
  }
  for (const fs::path& folder :
       {data_folder / "priors", InstalledFolder() / "configs" / "priors"}) {
    if (fs::is_directory(folder, error)) return std::optional<fs::path>(folder);
  }
  return std::optional<fs::path>();
}

}  // namespace deepslam::stages
