#include "deepslam/detect/cluster_detector.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "deepslam/detect/ground_clusters.h"
#include "deepslam/detect/ground_grid.h"
#include "deepslam/detect/seen_ends.h"

namespace deepslam::detect {
namespace {

// The class without detector labels whose sizes hold the cluster, most central first; the fallback
// if none does.
std::string ClassOf(const Cluster& cluster, const ClassTable& classes) {
  const double longest_m = std::max(cluster.long_side_m, cluster.max_height_m);
  const auto distance = [](double value, double low, double high) {
    return high > low ? std::abs(value - 0.5 * (low + high)) / (0.5 * (high - low)) : 2.0;
  };
  std::string best;
  double best_distance = 1.0;
  for (const ObjectClass& c : classes.classes) {
    if (!c.detector_labels.empty() || c.traits.fallback) continue;
    const double d = std::max(distance(longest_m, c.min_size_m, c.max_size_m),
                              distance(cluster.max_height_m, c.min_height_m, c.max_height_m));
    if (d <= best_distance) {
      best_distance = d;
      best = c.name;
    }
  }
  const ObjectClass* const fallback = classes.Fallback();
  if (best.empty() && fallback != nullptr) best = fallback->name;
  return best;
}

// Without its class.
Detection DetectionOf(const Cluster& cluster, const Frame& frame, double free_share) {
  Detection detection;
  detection.frame = frame.idx;
  detection.score = 0.3 + 0.4 * free_share;  // never above a good detection of a network
  detection.box_px = cluster.box_px;
  detection.source = DetectionSource::kCluster;
  Mask mask(frame.depth_m.width(), frame.depth_m.height());
  for (const GridPoint& p : cluster.points) mask(p.u, p.v) = 1;
  detection.mask = mask;
  return detection;
}

}  // namespace

FrameClusters FindClusters(const Frame& frame,
                           const PinholeCamera& camera,
                           const Plane& ground_camera,
                           const ClassTable& classes,
                           const ClusterOptions& options) {
  FrameClusters found;
  if (!options.enabled || frame.depth_m.empty() || !(camera.fx > 0) || !(camera.fy > 0))
    return found;
  const GroundGrid grid = SurveyGround(frame, camera, ground_camera);
  const Components components = ConnectCells(grid);
  const auto min_points = static_cast<std::size_t>(
      std::max(1.0, ClusterOptions::kMinPointsShare * static_cast<double>(frame.depth_m.size())));
  std::vector<Cluster> clusters =
      FindGroundClusters(frame.depth_m.width(), grid, components, min_points);
  for (Cluster& cluster : clusters) {
    found.boxes_px.push_back(cluster.box_px);
    if (!IsFurniture(cluster)) continue;
    const double free_share = FreeShare(grid, components, cluster);
    if (free_share < ClusterOptions::kMinFreeShare) continue;
    if (!EndsAreSeen(frame, camera, ground_camera, grid.wall, cluster)) continue;
    Detection detection = DetectionOf(cluster, frame, free_share);
    detection.class_name = ClassOf(cluster, classes);
    if (detection.class_name.empty()) continue;
    found.furniture.push_back({std::move(detection), found.boxes_px.size() - 1});
  }
  return found;
}

std::vector<Detection> DetectClusters(const Frame& frame,
                                      const PinholeCamera& camera,
                                      const Plane& ground_camera,
                                      std::span<const Detection> covered,
                                      const ClassTable& classes,
                                      const ClusterOptions& options) {
  return Uncovered(FindClusters(frame, camera, ground_camera, classes, options), covered);
}

}  // namespace deepslam::detect
