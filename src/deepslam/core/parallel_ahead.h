// A loop that prepares on all threads, a few steps ahead of need, what it uses in order. Results do
// not depend on the number of threads (see parallel.h).
#pragma once

#include <cstddef>
#include <functional>

namespace deepslam {

// Calls prepare(i) for every i in [0, count), in any order and on any thread, and use(i) in
// ascending order, one at a time and on any thread, when prepare(i) is done. Fewer than `ahead`
// (1 or more) others are prepared, or being prepared, and not used yet: slot i % ahead is free for
// prepare(i). Where use(i) gives false, nothing more is used. Exceptions must not leave either.
void ParallelAhead(std::size_t count,
                   std::size_t ahead,
                   const std::function<void(std::size_t)>& prepare,
                   const std::function<bool(std::size_t)>& use);

}  // namespace deepslam
