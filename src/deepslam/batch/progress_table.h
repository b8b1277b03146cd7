// What a person sees of a batch at work.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "deepslam/batch/batch_state.h"

namespace deepslam::batch {

struct TableOptions {
  int width = 80;   // columns of the terminal
  int height = 24;  // its rows; the table stays below
};

// Lines without escapes or line ends, none wider than the terminal: counts and time left, then what
// runs with stage and time left, then the last failures with their reasons. `stages` are those of
// the chain, in order; `now_s` is since 1970.
[[nodiscard]] std::vector<std::string> RenderTable(const BatchState& batch,
                                                   std::span<const std::string> stages,
                                                   double now_s,
                                                   const TableOptions& options);

// The line that tells that a capture ended: "kitchen: done in 23.1 s, good, 2 chairs, 1 table".
[[nodiscard]] std::string EndLine(const CaptureRecord& record);

// "2 chair, 1 table"; "no objects".
[[nodiscard]] std::string ObjectsText(const CaptureRecord& record);

// "41 s", "3 min 12 s", "2 h 05 min".
[[nodiscard]] std::string DurationText(double seconds);

}  // namespace deepslam::batch
