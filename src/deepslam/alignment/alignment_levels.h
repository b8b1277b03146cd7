// Levels of a pyramid that hold enough to align by.
#pragma once

#include <cstddef>

#include "deepslam/alignment/image_pyramid.h"

namespace deepslam::alignment {

// Coarser ones hold too few points for all six directions; they serve the rotation search. At least
// one.
[[nodiscard]] inline std::size_t NumAlignmentLevels(const FramePyramid& pyramid) {
  constexpr int kMinWidth = 60;
  std::size_t count = 1;
  while (count < pyramid.levels.size() && pyramid.levels[count].camera.width >= kMinWidth) ++count;
  return count;
}

}  // namespace deepslam::alignment
