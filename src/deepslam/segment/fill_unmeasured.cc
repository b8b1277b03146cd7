#include "deepslam/segment/fill_unmeasured.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace deepslam::segment {
namespace {

// Up to which width pixels without depth between two of the mask are filled.
struct Gap {
  double focal_px = 0;
  double gap_m = 0;

  [[nodiscard]] bool IsClosed(int num_pixels, float depth_a_m, float depth_b_m) const {
    const double nearer_m = std::min(depth_a_m, depth_b_m);
    return num_pixels * nearer_m <= gap_m * focal_px;
  }
};

// Calls visit(u, v) for the pixels of closed gaps within rows.
template <typename Visitor>
void VisitGapsOfRows(const DepthImage& depth_m,
                     const Mask& mask,
                     const Region& region,
                     const Gap& gap,
                     const Visitor& visit) {
  for (int v = region.v_min; v <= region.v_max; ++v) {
    const float* const depth = depth_m.row(v);
    const std::uint8_t* const in_mask = mask.row(v);
    int before = -1;  // the last pixel with depth
    for (int u = region.u_min; u <= region.u_max; ++u) {
      if (!(depth[u] > 0)) continue;
      if (before >= 0 && before + 1 < u && in_mask[u] != 0 && in_mask[before] != 0 &&
          gap.IsClosed(u - before - 1, depth[u], depth[before])) {
        for (int k = before + 1; k < u; ++k) visit(k, v);
      }
      before = u;
    }
  }
}

// The same within columns; these are read row by row.
template <typename Visitor>
void VisitGapsOfColumns(const DepthImage& depth_m,
                        const Mask& mask,
                        const Region& region,
                        const Gap& gap,
                        const Visitor& visit) {
  std::vector<int> last(static_cast<std::size_t>(region.u_max - region.u_min) + 1, -1);
  for (int v = region.v_min; v <= region.v_max; ++v) {
    const float* const depth = depth_m.row(v);
    const std::uint8_t* const in_mask = mask.row(v);
    for (int u = region.u_min; u <= region.u_max; ++u) {
      if (!(depth[u] > 0)) continue;
      int& before = last[static_cast<std::size_t>(u - region.u_min)];
      if (before >= 0 && before + 1 < v && in_mask[u] != 0 && mask(u, before) != 0 &&
          gap.IsClosed(v - before - 1, depth[u], depth_m(u, before))) {
        for (int k = before + 1; k < v; ++k) visit(u, k);
      }
      before = v;
    }
  }
}

}  // namespace

void FillUnmeasured(const DepthImage& depth_m,
                    const PinholeCamera& camera,
                    const Region& region,
                    double gap_m,
                    Mask& taken,
                    Mask& mask) {
  if (region.empty() || !(gap_m > 0)) return;
  std::vector<std::pair<int, int>> filled;
  const auto fill = [&](int u, int v) {
    if (region.Contains(u, v) && taken(u, v) == 0) filled.emplace_back(u, v);
  };
  VisitGapsOfRows(depth_m, mask, region, {camera.fx, gap_m}, fill);
  VisitGapsOfColumns(depth_m, mask, region, {camera.fy, gap_m}, fill);
  for (const auto& [u, v] : filled) {
    mask(u, v) = 1;
    taken(u, v) = 1;
  }
}

}  // namespace deepslam::segment
