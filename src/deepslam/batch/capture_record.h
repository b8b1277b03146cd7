// What is known of one capture of a batch. Workers write it beside the workspaces, one file per
// capture; batch.json holds all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/json_value.h"
#include "deepslam/core/result.h"

namespace deepslam::batch {

enum class CaptureState { kWaiting, kRunning, kDone, kFailed, kInterrupted };
[[nodiscard]] std::string_view NameOf(CaptureState state);

// Error of the camera path against the poses that came with the capture.
struct PathError {
  double ate_rmse_m = 0;
  int num_scored = 0;  // frames of the estimate that have a true pose
  int num_frames = 0;
};

struct CaptureRecord {
  std::string name;
  std::string capture;  // path
  CaptureState state = CaptureState::kWaiting;
  std::string reason;  // kFailed, kInterrupted: what went wrong, and what to do
  int exit_code = 0;   // as `deepslam run` would have ended
  int attempts = 0;    // starts so far; a task of a lost node starts again
  std::string host;    // where it ran last
  int process = 0;     // kRunning: the worker's process id

  // kRunning: the stage it is in and its steps
  std::string stage;
  std::size_t done = 0;
  std::size_t total = 0;

  std::int64_t started_s = 0;  // since 1970, of the last attempt; 0: never
  std::int64_t ended_s = 0;
  double wall_s = 0;      // of all attempts that did something, together
  double attempt_s = 0;   // of the last attempt that did something
  std::map<std::string, double> stage_s;  // wall time of each stage that lies in the workspace

  // kDone, after the whole chain
  std::string verdict;  // good, doubtful, bad; empty: the chain was not run to its end
  std::vector<std::string> verdict_reasons;
  std::map<std::string, int> objects;  // class -> number
  int num_frames = 0;
  std::optional<PathError> path_error;  // where poses came with the capture and were not used
  std::int64_t num_bytes = 0;           // of the workspace
};

[[nodiscard]] int NumObjects(const CaptureRecord& record);

[[nodiscard]] artifact::JsonValue ToJson(const CaptureRecord& record);
[[nodiscard]] Result<std::string> EncodeRecord(const CaptureRecord& record, std::string_view name);
[[nodiscard]] Result<CaptureRecord> DecodeRecord(std::string_view text, std::string_view name);

}  // namespace deepslam::batch
