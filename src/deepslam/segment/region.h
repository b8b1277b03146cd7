// The pixels that one detection may claim: its box, cut by its instance mask where it has one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/scene/detection.h"
#include "deepslam/segment/segment_objects.h"

namespace deepslam::segment {

struct Region {
  int u_min = 0;
  int v_min = 0;
  int u_max = -1;  // inclusive; below u_min: the region is empty
  int v_max = -1;
  Mask mask;  // widened instance mask of the image; empty: the whole box

  [[nodiscard]] bool empty() const { return u_max < u_min || v_max < v_min; }
  [[nodiscard]] bool Contains(int u, int v) const {
    return u >= u_min && u <= u_max && v >= v_min && v <= v_max &&
           (mask.empty() || mask(u, v) != 0);
  }
  [[nodiscard]] int area_px() const {
    return empty() ? 0 : (u_max - u_min + 1) * (v_max - v_min + 1);
  }
  // Calls visit(u, v) for every pixel, row by row.
  template <typename Visitor>
  void ForEach(const Visitor& visit) const {
    for (int v = v_min; v <= v_max; ++v) {
      const std::uint8_t* const inside = mask.empty() ? nullptr : mask.row(v);
      for (int u = u_min; u <= u_max; ++u) {
        if (inside == nullptr || inside[u] != 0) visit(u, v);
      }
    }
  }
};

// One per detection. Boxes that are not finite or lie outside the image give empty regions; masks
// of a wrong size are not used.
[[nodiscard]] std::vector<Region> MakeRegions(std::span<const Detection> detections,
                                              int width,
                                              int height,
                                              const SegmentOptions& options);

// Which detection (index) owns each pixel, -1 = none.
using Owners = Image<std::int32_t>;

}  // namespace deepslam::segment
