#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/detect/cluster_detector.h"

namespace deepslam::detect {
namespace {

// By all detections together; outlines leave a rim uncovered.
constexpr double kWhollyCovered = 0.8;

// Of a cluster's pixels, which are those of its mask.
double CoveredShare(const Detection& cluster, std::span<const Detection> covered) {
  const Box2& box = cluster.box_px;
  const Mask mask = cluster.mask.Unpacked();
  std::size_t num_pixels = 0;
  std::size_t num_covered = 0;
  for (int v = static_cast<int>(box.v_min); v <= static_cast<int>(box.v_max); ++v) {
    for (int u = static_cast<int>(box.u_min); u <= static_cast<int>(box.u_max); ++u) {
      if (mask(u, v) == 0) continue;
      ++num_pixels;
      num_covered += std::any_of(covered.begin(),
                                 covered.end(),
                                 [&](const Detection& d) { return d.box_px.Contains(u, v); })
                         ? 1U
                         : 0U;
    }
  }
  return static_cast<double>(num_covered) / static_cast<double>(num_pixels);
}

// For each detection the cluster whose box is most like its own: what it has found. As many as
// there are boxes where there is none.
std::vector<std::size_t> FoundBy(std::span<const Detection> detections,
                                 std::span<const Box2> boxes_px) {
  std::vector<std::size_t> found;
  for (const Detection& detection : detections) {
    const auto best =
        std::max_element(boxes_px.begin(), boxes_px.end(), [&](const Box2& a, const Box2& b) {
          return IntersectionOverUnion(detection.box_px, a) <
                 IntersectionOverUnion(detection.box_px, b);
        });
    found.push_back(static_cast<std::size_t>(best - boxes_px.begin()));
  }
  return found;
}

// A box reaches over what stands before the thing it is of: only the cluster it has found is its
// own, and what lies in boxes nearly wholly.
bool IsExplained(const FrameClusters::Furniture& furniture,
                 std::span<const Detection> detections,
                 std::span<const std::size_t> found,
                 double max_covered_share) {
  const Detection& cluster = furniture.detection;
  if (CoveredShare(cluster, detections) > kWhollyCovered) return true;
  for (std::size_t n = 0; n < detections.size(); ++n) {
    if (found[n] == furniture.cluster &&
        CoveredShare(cluster, detections.subspan(n, 1)) > max_covered_share)
      return true;
  }
  return false;
}

}  // namespace

std::vector<Detection> Uncovered(FrameClusters clusters, std::span<const Detection> covered) {
  const std::vector<std::size_t> found = FoundBy(covered, clusters.boxes_px);
  std::vector<Detection> detections;
  for (FrameClusters::Furniture& furniture : clusters.furniture) {
    if (IsExplained(furniture, covered, found, ClusterOptions::kMaxCoveredShare)) continue;
    detections.push_back(std::move(furniture.detection));
  }
  return detections;
}

}  // namespace deepslam::detect
