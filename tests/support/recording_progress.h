// Progress that keeps what it is told, and can ask to stop.
#pragma once

#include <atomic>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/progress.h"

namespace deepslam::testing_support {

class RecordingProgress final : public Progress {
 public:
  // Asks to stop when it was asked so many times; 0: never.
  explicit RecordingProgress(int stop_after = 0) : stop_after_(stop_after) {}

  void Report(std::size_t done, std::size_t total) override {
    last_done = done;
    last_total = total;
  }
  void Warn(std::string_view message) override { warnings.emplace_back(message); }
  [[nodiscard]] bool StopRequested() const override {
    return stop_after_ > 0 && ++times_asked_ >= stop_after_;
  }

  std::vector<std::string> warnings;
  std::size_t last_done = 0;
  std::size_t last_total = 0;

 private:
  int stop_after_;
  mutable std::atomic<int> times_asked_ = 0;
};

}  // namespace deepslam::testing_support
