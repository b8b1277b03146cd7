#include "deepslam/pipeline/decide.h"

#include <utility>

#include <fmt/format.h>

#include "deepslam/pipeline/drop.h"
#include "deepslam/storage/store.h"

namespace deepslam::pipeline {
namespace {

namespace fs = std::filesystem;

void CompareMaps(const std::map<std::string, std::string>& before,
                 const std::map<std::string, std::string>& after,
                 std::string_view what,
                 bool show_values,
                 std::vector<std::string>& reasons) {
  for (const auto& [name, value] : after) {
    const auto it = before.find(name);
    if (it == before.end()) {
      reasons.push_back(fmt::format("{} {} is new", what, name));
    } else if (it->second != value) {
      reasons.push_back(show_values ? fmt::format("{} {} {} -> {}", what, name, it->second, value)
                                    : fmt::format("{} {} changed", what, name));
    }
  }
  for (const auto& [name, value] : before) {
    if (!after.contains(name)) reasons.push_back(fmt::format("{} {} is gone", what, name));
  }
}

std::vector<std::string> DamagedOutputs(const fs::path& folder, const Manifest& manifest) {
  std::vector<std::string> reasons;
  for (const auto& [file, output] : manifest.outputs) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(folder / file, error);
    if (error) {
      reasons.push_back(fmt::format("output missing: {}", file));
      continue;
    }
    const Result<std::string> hash = storage::HashFile(folder / file);
    if (size != output.num_bytes || !hash.ok() || *hash != output.sha256) {
      reasons.push_back(fmt::format("output damaged: {}", file));
    }
  }
  return reasons;
}

}  // namespace

Manifest Expected(const Stage& stage,
                  std::map<std::string, std::string> inputs,
                  std::map<std::string, std::string> external_inputs) {
  Manifest manifest;
  manifest.stage = stage.name;
  manifest.stage_version = stage.version;
  manifest.options = stage.options;
  manifest.inputs = std::move(inputs);
  manifest.external_inputs = std::move(external_inputs);
  return manifest;
}

std::vector<std::string> Differences(const Manifest& old_manifest, const Manifest& expected) {
  std::vector<std::string> reasons;
  if (old_manifest.stage_version != expected.stage_version) {
    reasons.push_back(fmt::format("made by version {} of the stage, this is version {}",
                                  old_manifest.stage_version,
                                  expected.stage_version));
  }
  CompareMaps(old_manifest.options, expected.options, "option", true, reasons);
  CompareMaps(old_manifest.external_inputs, expected.external_inputs, "input", false, reasons);
  CompareMaps(old_manifest.inputs, expected.inputs, "input", false, reasons);
  return reasons;
}

Decision Decide(const fs::path& workspace, const Manifest& expected) {
  const fs::path folder = workspace / expected.stage;
  Decision decision;
  std::error_code error;
  if (!fs::exists(folder / kManifestFile, error)) {
    decision.missing = true;
    decision.reasons.emplace_back("missing");
    return decision;
  }
  const Result<std::string> text = storage::ReadFile(folder / kManifestFile);
  const std::string name = fmt::format("{}/{}", expected.stage, kManifestFile);
  Result<Manifest> found = text.ok() ? DecodeManifest(*text, name) : Result<Manifest>(text.error());
  if (!found.ok()) {
    decision.reasons.push_back("manifest unusable: " + found.error().message);
    return decision;
  }
  decision.manifest = std::move(found).value();
  decision.reasons = Differences(*decision.manifest, expected);
  if (!decision.reasons.empty()) return decision;
  DEEPSLAM_CHECK(Key(*decision.manifest) == Key(expected), "equal manifests have equal keys");
  decision.dropped = IsDropped(workspace, expected.stage);
  if (!decision.dropped) decision.reasons = DamagedOutputs(folder, *decision.manifest);
  return decision;
}

}  // namespace deepslam::pipeline
