// The page's part about places seen again.
#pragma once

#include <string>

#include "deepslam/scene/loop.h"

namespace deepslam::report {

// A table of all loops, accepted and refused, by their kind; a sentence where there are none.
[[nodiscard]] std::string LoopSection(const Loops& loops);

}  // namespace deepslam::report
