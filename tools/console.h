// What a person at a terminal sees: log lines, a progress bar, and Ctrl-C.
#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/pipeline/runner.h"

namespace deepslam::tools {

// Log lines go to stderr. Levels: error, warning, info, debug.
void SetUpLogging(const std::string& level);
void LogInfo(std::string_view line);
void LogWarning(std::string_view line);
void LogError(std::string_view line);

// From now on SIGINT and SIGTERM ask the running stage to stop; a second one kills as usual.
void CatchStopSignals();
// A limit on file sizes then fails the write that meets it, with a message, instead of ending the
// program.
void TurnFileSizeSignalIntoError();
[[nodiscard]] bool StopSignalled();

enum class ProgressStyle { kBar, kLines, kJson, kNone };
// "auto" is a bar on a terminal and lines elsewhere.
[[nodiscard]] ProgressStyle ParseProgressStyle(std::string_view name);

// Tells what the runner does, on stderr.
class ConsoleListener final : public pipeline::RunListener {
 public:
  // `explain`: also say why each stage runs or not.
  ConsoleListener(ProgressStyle style, bool explain);

  void StageSkipped(std::string_view stage, std::string_view summary) override;
  void StageStarts(std::string_view stage, std::span<const std::string> reasons) override;
  void StageDone(std::string_view stage,
                 std::string_view summary,
                 const pipeline::Timing& timing) override;
  void Report(std::size_t done, std::size_t total) override;
  void Warn(std::string_view message) override;
  // Removes the bar, for work that is no stage.
  void EndProgress() { ClearBar(); }
  [[nodiscard]] bool StopRequested() const override { return StopSignalled(); }

 private:
  void ClearBar();
  void Event(std::string_view event, std::string_view text);

  ProgressStyle style_;
  bool explain_;
  std::string stage_;
  bool bar_shown_ = false;
  int num_warnings_ = 0;  // of this stage
  std::chrono::steady_clock::time_point last_report_;
};

}  // namespace deepslam::tools
