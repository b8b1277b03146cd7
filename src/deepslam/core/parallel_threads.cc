// Takes parallel.cc's place in builds with ThreadSanitizer, which knows nothing of what the
// packaged oneTBB does between threads: plain threads, and nothing that orders one body after
// another, so that every two bodies that touch the same memory are seen.
#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "deepslam/core/parallel.h"
#include "deepslam/core/parallel_ahead.h"

namespace deepslam {
namespace {

// Even where there are fewer cores.
constexpr std::size_t kFewestThreads = 2;
constexpr std::size_t kMostThreads = 4;  // ThreadSanitizer keeps a shadow of each thread's work

thread_local bool alone = false;

std::size_t NumThreads() {
  const std::size_t bound =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  if (alone) return 1;
  return std::clamp(bound, kFewestThreads, kMostThreads);
}

}  // namespace

void ParallelFor(std::size_t count, const std::function<void(std::size_t)>& body) {
  const std::size_t num_threads = std::min(NumThreads(), count);
  // Dealt out beforehand: every thread has bodies, however soon the first one is done. A loop
  // inside a body stays on its thread.
  const auto work = [&](std::size_t thread) {
    const bool was_alone = std::exchange(alone, true);
    for (std::size_t i = thread; i < count; i += num_threads) body(i);
    alone = was_alone;
  };
  std::vector<std::thread> others;
  for (std::size_t n = 1; n < num_threads; ++n) others.emplace_back(work, n);
  if (count > 0) work(0);
  for (std::thread& other : others) other.join();
}

// In batches: one is used by the first body while the others prepare the next.
void ParallelAhead(std::size_t count,
                   std::size_t ahead,
                   const std::function<void(std::size_t)>& prepare,
                   const std::function<bool(std::size_t)>& use) {
  const std::size_t batch = std::max<std::size_t>(1, ahead / 2);
  bool stopped = false;
  const auto use_all = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !stopped; ++i) stopped = !use(i);
  };
  for (std::size_t begin = 0; begin < count + batch && !stopped; begin += batch) {
    const std::size_t next = std::min(begin, count), end = std::min(begin + batch, count);
    const auto use_batch = [&] { use_all(begin < batch ? 0 : begin - batch, next); };
    if (ahead < 2) use_batch();
    ParallelFor(end - next + 1, [&](std::size_t task) {
      if (task > 0) return prepare(next + task - 1);
      if (ahead >= 2) use_batch();
    });
  }
}

void OnOneThread(const std::function<void()>& body) {
  const bool was_alone = std::exchange(alone, true);
  tbb::task_arena(1).execute([&] { body(); });
  alone = was_alone;
}

}  // namespace deepslam
