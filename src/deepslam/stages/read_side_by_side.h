// A stage's inputs read by several threads at once: parsing them is what keeps others waiting at
// its start.
#pragma once

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/core/parallel_in_order.h"
#include "deepslam/core/result.h"

namespace deepslam::stages {

template <typename T>
Status Take(Result<T> result, T& value) {
  if (!result.ok()) return result.error();
  value = std::move(result).value();
  return Ok();
}

// What takes longest should come first. The error of the first reader that has one.
inline Status ReadSideBySide(std::span<const std::function<Status()>> readers) {
  std::vector<Status> statuses(readers.size());
  ParallelInOrder(readers.size(), [&](std::size_t n) { statuses[n] = readers[n](); });
  for (const Status& status : statuses) {
    if (!status.ok()) return status;
  }
  return Ok();
}

}  // namespace deepslam::stages
