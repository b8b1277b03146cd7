// What is the same whatever runs the threads.
#include <algorithm>
#include <memory>

#include <tbb/global_control.h>

#include "deepslam/core/parallel.h"

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

void ParallelForChunks(std::size_t count,
                       std::size_t chunk,
                       const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t num_chunks = (count + chunk - 1) / chunk;
  ParallelFor(num_chunks,
              [&](std::size_t c) { body(c * chunk, std::min(count, (c + 1) * chunk)); });
}

}  // namespace deepslam
