// Networks and libraries out of their folders; and those that the runs of one process share: loaded
// once, and again only when their files changed.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "deepslam/core/result.h"
#include "deepslam/detect/detector.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/scene/model_library.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::stages {

// For one thread at a time. Files are taken as unchanged while StateOf() is (content_hashes.h).
class ModelCache {
 public:
  // Messages name the file. Another file, or other options, take the place of what was held.
  [[nodiscard]] Result<std::shared_ptr<const detect::Detector>> Detector(
      const std::filesystem::path& onnx_file, const detect::DetectorOptions& options);
  [[nodiscard]] Result<std::shared_ptr<const ModelLibrary>> Library(
      const std::filesystem::path& folder);
  // Of those of the classes that have a folder CLASS/, with sketch.onnx, encoder.onnx and
  // decoder.onnx; what was opened for other classes stays.
  [[nodiscard]] Result<propose::ShapePriors> Priors(const std::filesystem::path& folder,
                                                    const std::set<std::string>& classes);

 private:
  template <typename T>
  struct Held {
    std::string source;  // path and state of the files, and the options, it was loaded from
    std::shared_ptr<const T> value;
  };
  Held<detect::Detector> detector_;
  Held<ModelLibrary> library_;
  std::string priors_source_;
  propose::ShapePriors priors_;  // of every class that was asked for so far
};

// Where a run's networks and libraries are found. A cache shares them between the stages of a run
// and the runs of a process; none: they are loaded anew.
struct ModelFolders {
  std::filesystem::path data_folder;
  std::shared_ptr<ModelCache> cache;
};

// Those of the folder named (FindPriors in data_folder.h); null where none is named and none is
// there. With `only` no other classes' networks are opened: what no object needs costs nothing, and
// is not looked at. InvalidInput also when the folder holds networks of no class of the table.
[[nodiscard]] Result<std::shared_ptr<const propose::ShapePriors>> FindShapePriors(
    const ModelFolders& folders,
    const std::string& named,
    const ClassTable& classes,
    const std::optional<std::set<std::string>>& only = std::nullopt);

// Likewise (FindLibrary).
[[nodiscard]] Result<std::shared_ptr<const ModelLibrary>> FindModelLibrary(
    const ModelFolders& folders, const std::string& named);

// The detector of an ONNX file, loaded anew.
[[nodiscard]] Result<std::unique_ptr<detect::Detector>> LoadDetectorFile(
    const std::filesystem::path& onnx_file, const detect::DetectorOptions& options);

}  // namespace deepslam::stages
