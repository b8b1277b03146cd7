#include "deepslam/segment/region.h"

#include <cmath>

namespace deepslam::segment {
namespace {

// Widened by a square of +-radius; separable.
Mask Widened(const Mask& mask, int radius) {
  const auto spread = [radius](const Mask& in, bool along_u) {
    Mask out(in.width(), in.height());
    for (int v = 0; v < in.height(); ++v) {
      for (int u = 0; u < in.width(); ++u) {
        if (in(u, v) == 0) continue;
        const int at = along_u ? u : v;
        const int end = (along_u ? in.width() : in.height()) - 1;
        for (int s = std::max(0, at - radius); s <= std::min(end, at + radius); ++s) {
          out(along_u ? s : u, along_u ? v : s) = 1;
        }
      }
    }
    return out;
  };
  return spread(spread(mask, true), false);
}

}  // namespace

std::vector<Region> MakeRegions(std::span<const Detection> detections,
                                int width,
                                int height,
                                const SegmentOptions& options) {
  std::vector<Region> regions;
  for (const Detection& detection : detections) {
    Region region;
    const Box2 box = Intersection(detection.box_px, {0, 0, width - 1.0, height - 1.0});
    const bool finite = std::isfinite(box.u_min) && std::isfinite(box.v_min) &&
                        std::isfinite(box.u_max) && std::isfinite(box.v_max);
    if (finite && !box.empty()) {
      region.u_min = static_cast<int>(std::ceil(box.u_min));
      region.v_min = static_cast<int>(std::ceil(box.v_min));
      region.u_max = static_cast<int>(std::floor(box.u_max));
      region.v_max = static_cast<int>(std::floor(box.v_max));
      if (detection.mask.width() == width && detection.mask.height() == height) {
        region.mask =
            Widened(detection.mask.Unpacked(), static_cast<int>(options.mask_dilation_px));
      }
    }
    regions.push_back(std::move(region));
  }
  return regions;
}

}  // namespace deepslam::segment
