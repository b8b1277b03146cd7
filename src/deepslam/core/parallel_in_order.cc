#include "deepslam/core/parallel_in_order.h"

#include <atomic>

#include "deepslam/core/parallel.h"

namespace deepslam {

void ParallelInOrder(std::size_t count, const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> next = 0;
  ParallelFor(count, [&](std::size_t) { body(next++); });
}

}  // namespace deepslam
