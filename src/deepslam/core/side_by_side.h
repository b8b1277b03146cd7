// Work that may fail, done by several threads at once: where several inputs are read, parsing them
// is what keeps others waiting.
#pragma once

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/core/parallel_in_order.h"
#include "deepslam/core/result.h"

namespace deepslam {

// The value into its place, or the error.
template <typename T>
[[nodiscard]] Status Take(Result<T> result, T& value) {
  if (!result.ok()) return result.error();
  value = std::move(result).value();
  return Ok();
}

// What takes longest should come first. The error of the first task that has one.
[[nodiscard]] inline Status RunSideBySide(std::span<const std::function<Status()>> tasks) {
  std::vector<Status> statuses(tasks.size());
  ParallelInOrder(tasks.size(), [&](std::size_t n) { statuses[n] = tasks[n](); });
  for (const Status& status : statuses) {
    if (!status.ok()) return status;
  }
  return Ok();
}

}  // namespace deepslam
