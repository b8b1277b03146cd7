// Parallel loops whose results do not depend on the number of threads: bodies write by index,
// reductions happen afterwards in index order. The thread count is an argument of the process (see
// ThreadLimit), never of a key.
#pragma once

#include <cstddef>
#include <functional>

namespace deepslam {

// Bounds the worker threads of every ParallelFor in this process while the object lives.
class ThreadLimit {
 public:
  explicit ThreadLimit(int num_threads);  // 0: all cores
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  Impl* impl_;
};

// Calls body(i) for every i in [0, count), in any order and on any thread. Exceptions must not
// leave `body`.
void ParallelFor(std::size_t count, const std::function<void(std::size_t)>& body);

// Calls body(begin, end) for consecutive chunks of `chunk` indices; chunk bounds depend on `count`
// and `chunk` only.
void ParallelForChunks(std::size_t count,
                       std::size_t chunk,
                       const std::function<void(std::size_t, std::size_t)>& body);

// Runs `body` so that parallel loops inside it, ours and those of libraries on the same scheduler,
// get no thread but the caller's.
void OnOneThread(const std::function<void()>& body);

}  // namespace deepslam
