#include "deepslam/core/parallel.h"

#include <atomic>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "deepslam/core/parallel_ahead.h"

namespace deepslam {

void ParallelFor(std::size_t count, const std::function<void(std::size_t)>& body) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
      },
      tbb::simple_partitioner());
}

void ParallelAhead(std::size_t count,
                   std::size_t ahead,
                   const std::function<void(std::size_t)>& prepare,
                   const std::function<bool(std::size_t)>& use) {
  std::size_t next = 0;
  std::atomic<bool> stopped = false;
  const auto begin = [&](tbb::flow_control& flow) {
    if (next < count && !stopped) return next++;
    flow.stop();
    return count;
  };
  const auto prepare_one = [&](std::size_t i) {
    if (!stopped) prepare(i);
    return i;
  };
  const auto use_one = [&](std::size_t i) {
    if (!stopped && !use(i)) stopped = true;
  };
  using tbb::filter_mode;
  tbb::parallel_pipeline(
      ahead,
      tbb::make_filter<void, std::size_t>(filter_mode::serial_in_order, begin) &
          tbb::make_filter<std::size_t, std::size_t>(filter_mode::parallel, prepare_one) &
          tbb::make_filter<std::size_t, void>(filter_mode::serial_in_order, use_one));
}

void OnOneThread(const std::function<void()>& body) {
  tbb::task_arena(1).execute([&] { body(); });
}

}  // namespace deepslam
