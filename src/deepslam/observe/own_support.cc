#include "deepslam/observe/own_support.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "deepslam/core/order_statistics.h"
#include "deepslam/shape/view_points.h"

namespace deepslam::observe {
namespace {

constexpr int kFootPointsPerView = 500;  // of one view: the lowest two in a hundred are then ten
// Of all views; of fewer, one stray would decide the foot.
constexpr std::size_t kMinFootPoints = 30;
// Share of points below the foot: strays at the silhouette's border.
constexpr double kStrayShare = 0.02;
// Of things that may stand on the floor: a foot that something hides is seen to end this high
// above it; shelves and seats, the lowest furniture that carries things, are higher.
constexpr double kMaxHidden_m = 0.25;

// Height of the foot above the ground.
std::optional<double> FootOf(std::span<const ObjectView> views) {
  std::vector<double> heights_m;
  for (const ObjectView& view : views) {
    if (!view.ground_camera) continue;
    for (const Eigen::Vector3f& p_camera :
         shape::ExtractViewPoints(view, kFootPointsPerView).points_camera)
      heights_m.push_back(view.ground_camera->SignedDistance(p_camera.cast<double>()));
  }
  if (heights_m.size() < kMinFootPoints) return std::nullopt;
  const auto n = static_cast<std::size_t>(kStrayShare * static_cast<double>(heights_m.size()));
  return OrderStatistic(heights_m, n);
}

}  // namespace

void PutOnOwnSupport(const Supports& supports, std::span<ObjectView> views) {
  if (!supports.furniture && !supports.wall) return;
  const std::optional<double> foot_m = FootOf(views);
  // Wall cabinets, which no furniture carries, begin above what beds and tables hide.
  const double max_hidden_m = supports.furniture ? kMaxHidden_m : kMaxHiddenBase_m;
  if (!foot_m || *foot_m <= 0 || !supports.RestsElsewhere(*foot_m, max_hidden_m)) return;
  for (ObjectView& view : views) {
    if (view.ground_camera) view.ground_camera->d_m -= *foot_m;
  }
}

}  // namespace deepslam::observe
