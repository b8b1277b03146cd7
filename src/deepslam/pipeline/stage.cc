#include "deepslam/pipeline/stage.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/sha256.h"
#include "deepslam/storage/store.h"

namespace deepslam::pipeline {

StageContext::StageContext(std::filesystem::path workspace,
                           std::filesystem::path folder,
                           std::vector<std::string> inputs,
                           Progress& progress)
    : workspace_(std::move(workspace)),
      folder_(std::move(folder)),
      inputs_(std::move(inputs)),
      progress_(progress) {}

std::filesystem::path StageContext::PathTo(std::string_view stage, std::string_view file) const {
  DEEPSLAM_CHECK(std::find(inputs_.begin(), inputs_.end(), stage) != inputs_.end(),
                 fmt::format("stage {} is not declared as an input", stage));
  return workspace_ / stage / file;
}

Result<std::string> StageContext::Read(std::string_view stage, std::string_view file) const {
  return storage::ReadFile(PathTo(stage, file));
}

Result<TextSource> StageContext::Open(std::string_view stage, std::string_view file) const {
  return storage::OpenText(PathTo(stage, file));
}

Status StageContext::Write(std::string_view file, std::string_view bytes) {
  return Write(file, [bytes](const TextSink& sink) { return sink(bytes); });
}

Status StageContext::Write(std::string_view file, const TextWriter& text) {
  const std::filesystem::path path = folder_ / file;
  if (Status status = storage::MakeFolders(path.parent_path()); !status.ok()) return status;
  Sha256 hash;
  std::uintmax_t num_bytes = 0;
  const auto hashed = [&](const TextSink& to_file) {
    return text([&](std::string_view piece) {
      hash.Update(piece);
      num_bytes += piece.size();
      return to_file(piece);
    });
  };
  if (Status status = storage::WriteFileUnsynced(path, hashed); !status.ok()) return status;
  outputs_[std::string(file)] = {hash.HexDigest(), num_bytes};
  return Ok();
}

std::shared_ptr<storage::ScratchFile> StageContext::Scratch() const {
  const std::lock_guard<std::mutex> lock(scratch_mutex_);
  return scratch_.emplace_back(std::make_shared<storage::ScratchFile>(folder_));
}

std::optional<Error> StageContext::scratch_fault() const {
  for (const auto& file : scratch_) {
    if (const std::optional<Error> fault = file->fault()) return fault;
  }
  return std::nullopt;
}

std::string StageContext::DisplayName(std::string_view stage, std::string_view file) {
  return fmt::format("{}/{}", stage, file);
}

}  // namespace deepslam::pipeline
