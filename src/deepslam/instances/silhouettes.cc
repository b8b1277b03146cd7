#include "deepslam/instances/silhouettes.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <set>
#include <utility>

#include "deepslam/core/parallel.h"

namespace deepslam::instances {
namespace {

// Of each pixel: the instance whose surface its depth lies on; -1: none. `seen`: of each pixel the
// element, for the share of a thing that is in sight.
struct Labels {
  Image<int> instance;
  Image<int> element;
};

Labels LabelPixels(const SurfaceElements& elements,
                   const Instances& instances,
                   const DepthImage& depth_m,
                   const PinholeCamera& camera,
                   const Pose3& level_from_camera,
                   double max_depth_m) {
  Labels labels{Image<int>(depth_m.width(), depth_m.height(), -1),
                Image<int>(depth_m.width(), depth_m.height(), -1)};
  ParallelFor(static_cast<std::size_t>(depth_m.height()), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < depth_m.width(); ++u) {
      const double z_m = depth_m(u, v);
      if (z_m <= 0 || z_m > max_depth_m) continue;
      const Eigen::Vector3d p_level = level_from_camera * camera.Unproject(u, v, z_m);
      const std::optional<int> element = elements.Nearest(p_level.cast<float>());
      if (!element) continue;
      labels.element(u, v) = *element;
      labels.instance(u, v) = instances.of_element[static_cast<std::size_t>(*element)];
    }
  });
  return labels;
}

void AddPixel(int u, int v, const Eigen::Vector3d& p_camera, Silhouette& silhouette) {
  silhouette.mask(u, v) = 1;
  ++silhouette.num_points;
  silhouette.extent_camera.Extend(p_camera);
  Box2& box_px = silhouette.box_px;
  if (box_px.empty()) {
    box_px = {u - 0.5, v - 0.5, u + 0.5, v + 0.5};
    return;
  }
  box_px.u_min = std::min(box_px.u_min, u - 0.5);
  box_px.v_min = std::min(box_px.v_min, v - 0.5);
  box_px.u_max = std::max(box_px.u_max, u + 0.5);
  box_px.v_max = std::max(box_px.v_max, v + 0.5);
}

bool TouchesBorder(const Box2& box_px, const DepthImage& depth_m, double margin_px) {
  return box_px.u_min < margin_px || box_px.v_min < margin_px ||
         box_px.u_max > depth_m.width() - 1 - margin_px ||
         box_px.v_max > depth_m.height() - 1 - margin_px;
}

}  // namespace

void Describe(OptionsVisitor& visitor, SilhouetteOptions& options) {
  visitor.Field("max_depth_m", options.max_depth_m, {0.5, 20}, "m", "farther depth is not used");
  visitor.Field("min_points",
                options.min_points,
                {1, 1000000},
                "px",
                "silhouettes with fewer pixels are no view");
  visitor.Field("min_visible_share",
                options.min_visible_share,
                {0, 1},
                "1",
                "nor those that show a smaller share of the thing's surface");
  visitor.Field("border_margin_px",
                options.border_margin_px,
                {0, 200},
                "px",
                "a silhouette nearer to the image border touches it");
}

std::vector<Silhouette> FindSilhouettes(const SurfaceElements& elements,
                                        const Instances& instances,
                                        const DepthImage& depth_m,
                                        const PinholeCamera& camera,
                                        const Pose3& level_from_camera,
                                        const SilhouetteOptions& options) {
  const Labels labels =
      LabelPixels(elements, instances, depth_m, camera, level_from_camera, options.max_depth_m);
  std::vector<std::size_t> num_pixels(instances.instances.size(), 0);
  std::vector<std::set<int>> visible(instances.instances.size());
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      const int k = labels.instance(u, v);
      if (k < 0) continue;
      ++num_pixels[static_cast<std::size_t>(k)];
      visible[static_cast<std::size_t>(k)].insert(labels.element(u, v));
    }
  }
  std::vector<Silhouette> silhouettes;
  std::vector<int> place(instances.instances.size(), -1);
  for (std::size_t k = 0; k < instances.instances.size(); ++k) {
    const Instance& instance = instances.instances[k];
    const double least = options.min_visible_share * static_cast<double>(instance.elements.size());
    if (!instance.rejection.empty() ||
        num_pixels[k] < static_cast<std::size_t>(options.min_points) ||
        static_cast<double>(visible[k].size()) < least)
      continue;
    place[k] = static_cast<int>(silhouettes.size());
    silhouettes.emplace_back();
    silhouettes.back().instance = static_cast<int>(k);
    silhouettes.back().mask = Mask(depth_m.width(), depth_m.height());
  }
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      const int k = labels.instance(u, v);
      if (k < 0 || place[static_cast<std::size_t>(k)] < 0) continue;
      AddPixel(u,
               v,
               camera.Unproject(u, v, depth_m(u, v)),
               silhouettes[static_cast<std::size_t>(place[static_cast<std::size_t>(k)])]);
    }
  }
  for (Silhouette& silhouette : silhouettes)
    silhouette.touches_border = TouchesBorder(silhouette.box_px, depth_m, options.border_margin_px);
  return silhouettes;
}

}  // namespace deepslam::instances
