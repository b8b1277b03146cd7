#include "deepslam/segment/fill_unmeasured.h"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace deepslam::segment {
namespace {

// A row or a column of the region: pixel i lies at (u + i du, v + i dv).
struct Line {
  int u = 0;
  int v = 0;
  int du = 0;
  int dv = 0;
  int length = 0;
};

// Visits the runs of pixels without depth that two pixels of the mask enclose closely enough.
void VisitGaps(const DepthImage& depth_m,
               const Mask& mask,
               const Line& line,
               double focal_px,
               double gap_m,
               const std::function<void(int, int)>& visit) {
  int before = -1;  // the last pixel with depth
  for (int i = 0; i < line.length; ++i) {
    const int u = line.u + i * line.du;
    const int v = line.v + i * line.dv;
    if (!(depth_m(u, v) > 0)) continue;
    if (before >= 0 && before + 1 < i && mask(u, v) != 0) {
      const int u_before = line.u + before * line.du;
      const int v_before = line.v + before * line.dv;
      const double nearer_m = std::min(depth_m(u, v), depth_m(u_before, v_before));
      if (mask(u_before, v_before) != 0 && (i - before - 1) * nearer_m <= gap_m * focal_px) {
        for (int k = before + 1; k < i; ++k) visit(line.u + k * line.du, line.v + k * line.dv);
      }
    }
    before = i;
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
  const int width = region.u_max - region.u_min + 1;
  const int height = region.v_max - region.v_min + 1;
  for (int v = region.v_min; v <= region.v_max; ++v)
    VisitGaps(depth_m, mask, {region.u_min, v, 1, 0, width}, camera.fx, gap_m, fill);
  for (int u = region.u_min; u <= region.u_max; ++u)
    VisitGaps(depth_m, mask, {u, region.v_min, 0, 1, height}, camera.fy, gap_m, fill);
  for (const auto& [u, v] : filled) {
    mask(u, v) = 1;
    taken(u, v) = 1;
  }
}

}  // namespace deepslam::segment
