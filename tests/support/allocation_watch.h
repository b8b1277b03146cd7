// The largest single piece of memory that anything in the test program has asked for by `new`.
#pragma once

#include <cstddef>

namespace deepslam::testing_support {

void ForgetAllocations();
[[nodiscard]] std::size_t LargestAllocation();  // bytes, since then

}  // namespace deepslam::testing_support
