#include "deepslam/propose/depth_evidence.h"

#include <optional>
#include <utility>

#include "deepslam/core/parallel.h"

namespace deepslam::propose {

std::vector<shape::DepthView> LevelViews(std::span<const ObjectView> views,
                                         std::span<const std::size_t> chosen,
                                         const Pose3& level_from_world) {
  std::vector<std::optional<shape::DepthView>> made(chosen.size());
  ParallelFor(chosen.size(), [&](std::size_t n) {
    const ObjectView& view = views[chosen[n]];
    made[n].emplace(view, (level_from_world * view.world_from_camera).Inverse());
  });
  std::vector<shape::DepthView> level_views;
  level_views.reserve(made.size());
  for (std::optional<shape::DepthView>& view : made) level_views.push_back(*std::move(view));
  return level_views;
}

}  // namespace deepslam::propose
