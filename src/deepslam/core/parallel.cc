#include "deepslam/core/parallel.h"

#include <algorithm>
#include <memory>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace deepslam {

struct ThreadLimit::Impl {
  std::unique_ptr<tbb::global_control> control;
};

ThreadLimit::ThreadLimit(int num_threads) : impl_(new Impl) {
  if (num_threads > 0) {
    impl_->control = std::make_unique<tbb::global_control>(
        tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(num_threads));
  }
}

ThreadLimit::~ThreadLimit() { delete impl_; }

void ParallelFor(std::size_t count, const std::function<void(std::size_t)>& body) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
      },
      tbb::simple_partitioner());
}

void ParallelForChunks(std::size_t count,
                       std::size_t chunk,
                       const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t num_chunks = (count + chunk - 1) / chunk;
  ParallelFor(num_chunks,
              [&](std::size_t c) { body(c * chunk, std::min(count, (c + 1) * chunk)); });
}

void OnOneThread(const std::function<void()>& body) {
  tbb::task_arena(1).execute([&] { body(); });
}

}  // namespace deepslam
