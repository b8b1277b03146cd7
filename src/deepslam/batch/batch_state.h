// batch.json: the state of all captures of a batch, for programs.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/batch/capture_record.h"
#include "deepslam/core/result.h"

namespace deepslam::batch {

struct BatchState {
  std::string tool_version;
  std::string state;   // "running", "done", "interrupted"
  std::string engine;  // "local", "slurm"
  int jobs = 1;        // captures at a time; 0: as many as the cluster takes
  std::int64_t started_s = 0;  // since 1970, of this call
  std::int64_t ended_s = 0;    // 0: not yet
  std::vector<CaptureRecord> captures;  // in the order of the list
};

struct StateCounts {
  int waiting = 0, running = 0, done = 0, failed = 0, interrupted = 0;
};
[[nodiscard]] StateCounts Count(const BatchState& batch);

// 0: all done; 1: some failed; 130: interrupted before the end.
[[nodiscard]] int ExitCode(const BatchState& batch);

[[nodiscard]] Result<std::string> EncodeBatch(const BatchState& batch, std::string_view name);
[[nodiscard]] Result<BatchState> DecodeBatch(std::string_view text, std::string_view name);

// "2026-11-20T07:31:00Z"; "" for 0.
[[nodiscard]] std::string UtcText(std::int64_t seconds);

}  // namespace deepslam::batch
