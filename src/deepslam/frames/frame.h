// One RGB-D frame: colour and depth of the same size, depth registered to colour.
#pragma once

#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"

namespace deepslam {

struct Frame {
  FrameIdx idx;
  double time_s = 0;  // capture clock
  ColourImage colour;
  DepthImage depth_m;  // 0 = invalid
};

}  // namespace deepslam
