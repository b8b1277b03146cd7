// A batch on the screen: a live table on a terminal, a line per capture elsewhere.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/batch/batch_state.h"

namespace deepslam::tools {

enum class BatchStyle { kTable, kLines, kNone };
// "auto" is a table on a terminal and lines elsewhere.
[[nodiscard]] BatchStyle ParseBatchStyle(std::string_view name);

class BatchDisplay {
 public:
  // `stages`: of the chain, in order.
  BatchDisplay(BatchStyle style, std::vector<std::string> stages);
  ~BatchDisplay();
  BatchDisplay(const BatchDisplay&) = delete;
  BatchDisplay& operator=(const BatchDisplay&) = delete;

  // Takes the table away.
  void Finish() { Clear(); }
  // Draws the table again, a few times a second at most.
  void Update(const batch::BatchState& batch);
  // Tells that a capture ended, above the table.
  void Ended(const batch::CaptureRecord& record, std::size_t num_ended, std::size_t num_all);

 private:
  void Clear();

  BatchStyle style_;
  std::vector<std::string> stages_;
  std::size_t num_lines_ = 0;  // of the table on the screen
  std::chrono::steady_clock::time_point drawn_;
};

}  // namespace deepslam::tools
