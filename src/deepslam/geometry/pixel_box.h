// Boxes of sets of pixels.
#pragma once

#include <algorithm>

#include "deepslam/geometry/box.h"

namespace deepslam {

// Takes a pixel in, whose area reaches half a pixel to each side of its centre (u, v).
inline void ExtendByPixel(int u, int v, Box2& box_px) {
  if (box_px.empty()) {
    box_px = {u - 0.5, v - 0.5, u + 0.5, v + 0.5};
    return;
  }
  box_px.u_min = std::min(box_px.u_min, u - 0.5);
  box_px.v_min = std::min(box_px.v_min, v - 0.5);
  box_px.u_max = std::max(box_px.u_max, u + 0.5);
  box_px.v_max = std::max(box_px.v_max, v + 0.5);
}

}  // namespace deepslam
