// One capture through the chain: what `deepslam run` does, and what a batch does for each of its
// captures.
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/core/result.h"
#include "deepslam/dataset/capture.h"
#include "deepslam/pipeline/runner.h"
#include "deepslam/stages/config.h"
#include "deepslam/stages/content_hashes.h"
#include "deepslam/stages/model_cache.h"

namespace deepslam::tools {

// Options of the last run of a workspace, for `status`.
inline constexpr std::string_view kRunFile = "run.json";
[[nodiscard]] Result<std::string> EncodeRun(stages::Config config);
[[nodiscard]] Result<stages::Config> DecodeRun(std::string_view text);

// Corrections by hand in a workspace.
inline constexpr std::string_view kOverridesFile = "overrides.yaml";
// Those of the file that was named, else of the workspace's, else none.
[[nodiscard]] Result<Overrides> ReadOverrides(const std::filesystem::path& workspace,
                                              const std::filesystem::path& named);

// Whether the stage's files are those of this run: made, or found as it would have made them.
[[nodiscard]] bool Stands(const pipeline::RunReport& report, std::string_view stage);

struct CaptureRun {
  std::filesystem::path capture;
  std::filesystem::path workspace;
  std::filesystem::path data_folder;
  std::string until;                // last stage; empty: all
  std::set<std::string> force;      // stages that run although their files stand
  std::set<std::string> keep;       // stages whose files stay; empty: all
  std::filesystem::path overrides;  // empty: overrides.yaml of the workspace, if there is one
  int lock_patience_s = 0;          // how long to wait for another run in the workspace
  std::shared_ptr<stages::ModelCache> models;     // none: models are loaded for this run alone
  std::shared_ptr<stages::ContentHashes> hashes;  // of models; none: hashed for this run alone
};

struct CaptureRunResult {
  pipeline::RunReport report;
  std::vector<pipeline::StageTiming> timings;  // of all stages that lie in the workspace
  std::shared_ptr<const dataset::Capture> capture;
};

// Opens the capture, runs the stages, writes timing.html beside them. Warnings of the capture are
// logged.
[[nodiscard]] Result<CaptureRunResult> RunCapture(const CaptureRun& run,
                                                  const stages::Config& config,
                                                  pipeline::RunListener& listener);

}  // namespace deepslam::tools
