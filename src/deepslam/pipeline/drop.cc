#include "deepslam/pipeline/drop.h"

#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/pipeline/manifest.h"
#include "deepslam/storage/store.h"

namespace deepslam::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDroppedFile = "dropped.json";
constexpr std::string_view kFormat = "deepslam/dropped";
constexpr int kVersion = 1;  // of the format; raised when its fields change

}  // namespace

Status DropOutputs(const fs::path& workspace, const std::string& stage) {
  const fs::path folder = workspace / stage;
  std::error_code error;
  if (!fs::exists(folder / kManifestFile, error)) return Ok();
  // The mark comes first: a drop that is cut short is a drop.
  const Result<std::string> text = DumpJson(artifact::NewDocument(kFormat, kVersion), kDroppedFile);
  if (!text.ok()) return text.error();
  if (Status status = storage::WriteFileAtomically(folder / kDroppedFile, *text); !status.ok())
    return status;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const fs::path name = it->path().filename();
    if (name != kManifestFile && name != kTimingFile && name != kDroppedFile)
      files.push_back(it->path());
  }
  for (const fs::path& file : files) {
    fs::remove_all(file, error);
    if (error) return Failed(fmt::format("{}: cannot remove: {}", file.string(), error.message()));
  }
  return Ok();
}

bool IsDropped(const fs::path& workspace, const std::string& stage) {
  std::error_code error;
  return fs::exists(workspace / stage / kDroppedFile, error);
}

}  // namespace deepslam::pipeline
