// Runs a chain of stages in a workspace: skips what stands, redoes what does not, and never leaves
// half a stage.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/pipeline/manifest.h"
#include "deepslam/pipeline/stage.h"

namespace deepslam::pipeline {

// Hears what the runner does; also the progress of the running stage.
class RunListener : public Progress {
 public:
  virtual void StageSkipped(std::string_view stage, std::string_view summary) = 0;
  virtual void StageStarts(std::string_view stage, std::span<const std::string> reasons) = 0;
  virtual void StageDone(std::string_view stage,
                         std::string_view summary,
                         const Timing& timing) = 0;
};

struct RunRequest {
  std::filesystem::path workspace;
  std::string until;            // last stage to run; empty: all
  std::set<std::string> force;  // run although their files stand
  // Small files to be written into the workspace once it is held: name -> bytes.
  std::map<std::string, std::string> notes;
  // Stages whose files are to stay; those of the others are dropped once all is done (drop.h).
  // Empty: all stay.
  std::set<std::string> keep = {};
  // How long to wait for another run that holds the workspace.
  int lock_patience_s = 0;
};

struct RunReport {
  std::vector<std::string> ran;
  std::vector<std::string> skipped;
};

// `stages` in an order in which every input stands before its user. Errors: a stage's own, with its
// name in front; a locked, foreign or unwritable workspace; unknown names in the request
// (kInvalidConfig); kInterrupted.
[[nodiscard]] Result<RunReport> RunStages(std::span<const Stage> stages,
                                          const RunRequest& request,
                                          RunListener& listener);

// kDropped: made, and its files dropped since; nothing needs them now.
enum class StageState { kDone, kDropped, kStale, kMissing };

struct StageReport {
  std::string name;
  StageState state = StageState::kMissing;
  std::vector<std::string> reasons;
  std::string summary;
  std::uintmax_t num_bytes = 0;
  Timing timing;
};

struct StageTiming {
  std::string name;
  Timing timing;
};

// Times of the stages that lie in a workspace; stages without are left out.
[[nodiscard]] std::vector<StageTiming> ReadTimings(std::span<const Stage> stages,
                                                   const std::filesystem::path& workspace);

// The state of a workspace without touching it. External inputs are taken as unchanged (the capture
// may be elsewhere) but for those named in `looked_at`, which stages are asked for.
[[nodiscard]] Result<std::vector<StageReport>> InspectWorkspace(
    std::span<const Stage> stages,
    const std::filesystem::path& workspace,
    std::span<const std::string_view> looked_at = {});

}  // namespace deepslam::pipeline
