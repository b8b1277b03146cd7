// Whether reading frames met a fault of the machine (kFailed, read_bytes.h), or files that were read
// before and are gone. A frame that the disk did not give is no bad frame of the capture: what was
// made without it must not pass for the capture's.
#pragma once

#include <mutex>
#include <optional>

#include "deepslam/core/result.h"

namespace deepslam::dataset {

class ReadFaults {
 public:
  // Thread-safe. Errors of other kinds are not noted.
  void Note(const Error& error) {
    if (error.code != ErrorCode::kFailed) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!first_) first_ = error;
  }
  [[nodiscard]] std::optional<Error> first() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return first_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<Error> first_;
};

}  // namespace deepslam::dataset
