// Networks and libraries that the runs of one process share: loaded once, and again only when their
// files changed.
#pragma once

#include <filesystem>
#include <memory>
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
  [[nodiscard]] Result<std::shared_ptr<const propose::ShapePriors>> Priors(
      const std::filesystem::path& folder, const ClassTable& classes);

 private:
  template <typename T>
  struct Held {
    std::string source;  // path and state of the files, and the options, it was loaded from
    std::shared_ptr<const T> value;
  };
  Held<detect::Detector> detector_;
  Held<ModelLibrary> library_;
  Held<propose::ShapePriors> priors_;
};

// The detector of an ONNX file, loaded anew.
[[nodiscard]] Result<std::unique_ptr<detect::Detector>> LoadDetectorFile(
    const std::filesystem::path& onnx_file, const detect::DetectorOptions& options);

}  // namespace deepslam::stages
