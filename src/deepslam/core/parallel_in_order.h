// A parallel loop whose bodies begin in order, for work of which some takes long: put first,
// nothing large is left for the end, when other threads have no more to do.
#pragma once

#include <cstddef>
#include <functional>

namespace deepslam {

// ParallelFor() (see parallel.h), but that body(i) begins before body(i + 1).
void ParallelInOrder(std::size_t count, const std::function<void(std::size_t)>& body);

}  // namespace deepslam
