#include "deepslam/pipeline/consistency.h"

#include <map>
#include <string>

#include <fmt/format.h>

#include "deepslam/pipeline/manifest.h"
#include "deepslam/storage/store.h"

namespace deepslam::pipeline {
namespace {

namespace fs = std::filesystem;

// Stage -> its manifest.
std::map<std::string, Manifest> ReadManifests(const fs::path& workspace) {
  std::map<std::string, Manifest> manifests;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(workspace, error)) {
    const fs::path file = entry.path() / kManifestFile;
    const Result<std::string> text = storage::ReadFile(file);
    if (!text.ok()) continue;
    Result<Manifest> manifest = DecodeManifest(*text, file.string());
    if (manifest.ok()) manifests.emplace(entry.path().filename(), std::move(manifest).value());
  }
  return manifests;
}

}  // namespace

Status CheckConsistency(const fs::path& workspace) {
  const std::map<std::string, Manifest> manifests = ReadManifests(workspace);
  for (const auto& [stage, manifest] : manifests) {
    for (const auto& [input, hash] : manifest.inputs) {
      const auto made = manifests.find(input);
      if (made == manifests.end() || ContentHash(made->second.outputs) == hash) continue;
      return InvalidInput(
          fmt::format("{}: stage {} was made from another {} than lies there now, as after a run "
                      "that stopped before it; run `deepslam run CAPTURE -o {}` to its end",
                      workspace.string(),
                      stage,
                      input,
                      workspace.string()));
    }
  }
  return Status();
}

}  // namespace deepslam::pipeline
