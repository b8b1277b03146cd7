// manifest.json: from what a stage's files were made, and what they are. Times stand in timing.json
// beside it, so that manifests of equal runs are equal bytes.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/pipeline/stage.h"

namespace deepslam::pipeline {

inline constexpr std::string_view kManifestFile = "manifest.json";
inline constexpr std::string_view kTimingFile = "timing.json";

struct Manifest {
  std::string stage;
  int stage_version = 0;
  std::map<std::string, std::string> options;
  std::map<std::string, std::string> inputs;           // stage -> content hash of its outputs
  std::map<std::string, std::string> external_inputs;  // capture, weights ... -> content hash
  std::map<std::string, OutputFile> outputs;           // relative file -> what it holds
  StageSummary summary;
};

struct Timing {
  double wall_s = 0;
  double cpu_s = 0;
  double peak_memory_mib = 0;  // of the process while the stage ran
};

[[nodiscard]] Result<std::string> EncodeManifest(const Manifest& manifest, std::string_view name);
[[nodiscard]] Result<Manifest> DecodeManifest(std::string_view text, std::string_view name);
[[nodiscard]] Result<std::string> EncodeTiming(const Timing& timing, std::string_view name);
[[nodiscard]] Result<Timing> DecodeTiming(std::string_view text, std::string_view name);

// sha256 over stage, version, options and inputs: equal keys promise equal outputs.
[[nodiscard]] std::string Key(const Manifest& manifest);
// sha256 over names and hashes of the outputs: what later stages depend on.
[[nodiscard]] std::string ContentHash(const std::map<std::string, OutputFile>& outputs);

}  // namespace deepslam::pipeline
