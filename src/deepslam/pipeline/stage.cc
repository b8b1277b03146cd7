#include "deepslam/pipeline/stage.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/store.h"
#include "deepslam/core/sha256.h"

namespace deepslam::pipeline {

StageContext::StageContext(std::filesystem::path workspace,
                           std::filesystem::path folder,
                           std::vector<std::string> inputs,
                           Progress& progress)
    : workspace_(std::move(workspace)),
      folder_(std::move(folder)),
      inputs_(std::move(inputs)),
      progress_(progress) {}

Result<std::string> StageContext::Read(std::string_view stage, std::string_view file) const {
  DEEPSLAM_CHECK(std::find(inputs_.begin(), inputs_.end(), stage) != inputs_.end(),
                 fmt::format("stage {} is not declared as an input", stage));
  return artifact::ReadFile(workspace_ / stage / file);
}

Status StageContext::Write(std::string_view file, std::string_view bytes) {
  const std::filesystem::path path = folder_ / file;
  if (Status status = artifact::MakeFolders(path.parent_path()); !status.ok()) return status;
  if (Status status = artifact::WriteFileUnsynced(path, bytes); !status.ok()) return status;
  outputs_[std::string(file)] = {Sha256Hex(bytes), bytes.size()};
  return Ok();
}

std::string StageContext::DisplayName(std::string_view stage, std::string_view file) {
  return fmt::format("{}/{}", stage, file);
}

}  // namespace deepslam::pipeline
