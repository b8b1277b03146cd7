#include "deepslam/instances/silhouettes.h"

#include <cstddef>

#include "deepslam/geometry/pixel_box.h"

namespace deepslam::instances {
namespace {

std::vector<int> CountPixels(const PixelLabels& labels, std::size_t num_instances) {
  std::vector<int> counts(num_instances, 0);
  for (const int k : labels.instance) {
    if (k >= 0) ++counts[static_cast<std::size_t>(k)];
  }
  return counts;
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
  visitor.Field("fill_gap_m",
                options.fill_gap_m,
                {0, 1},
                "m",
                "gaps without depth up to this width inside a thing belong to it");
}

void FitToMask(const DepthImage& depth_m, const PinholeCamera& camera, Silhouette& silhouette) {
  silhouette.num_points = 0;
  silhouette.box_px = Box2();
  silhouette.extent_camera = Box3();
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      if (silhouette.mask(u, v) == 0) continue;
      ExtendByPixel(u, v, silhouette.box_px);
      const double z_m = depth_m(u, v);
      if (!(z_m > 0)) continue;
      ++silhouette.num_points;
      silhouette.extent_camera.Extend(camera.Unproject(u, v, z_m));
    }
  }
}

std::vector<Silhouette> FindSilhouettes(const DividedSurface& surface,
                                        std::span<const ShownInstance> shown,
                                        const DepthImage& depth_m,
                                        const PinholeCamera& camera,
                                        const Pose3& level_from_camera,
                                        const SilhouetteOptions& options) {
  const MeasuredView view{depth_m, camera, level_from_camera, options.max_depth_m};
  PixelLabels labels = LabelBySurface(surface, view);
  GrowIntoMasks(surface, view, shown, labels);
  GrowIntoLoose(surface, view, labels);
  const std::vector<int> num_pixels = CountPixels(labels, surface.instances.instances.size());
  FillUnmeasured(view, options.fill_gap_m, labels);
  std::vector<Silhouette> silhouettes;
  std::vector<int> place(num_pixels.size(), -1);
  for (std::size_t k = 0; k < place.size(); ++k) {
    const Instance& instance = surface.instances.instances[k];
    const double least = options.min_visible_share * static_cast<double>(instance.elements.size());
    if (!instance.rejection.empty() || num_pixels[k] < options.min_points ||
        labels.num_visible[k] < least)
      continue;
    place[k] = static_cast<int>(silhouettes.size());
    silhouettes.emplace_back();
    silhouettes.back().instance = static_cast<int>(k);
    silhouettes.back().mask = Mask(depth_m.width(), depth_m.height());
  }
  for (std::size_t pixel = 0; pixel < labels.instance.size(); ++pixel) {
    const int k = labels.instance.data()[pixel];
    if (k < 0 || place[static_cast<std::size_t>(k)] < 0) continue;
    silhouettes[static_cast<std::size_t>(place[static_cast<std::size_t>(k)])].mask.data()[pixel] =
        1;
  }
  for (Silhouette& silhouette : silhouettes) {
    FitToMask(depth_m, camera, silhouette);
    silhouette.touches_border = TouchesBorder(silhouette.box_px, depth_m, options.border_margin_px);
  }
  return silhouettes;
}

}  // namespace deepslam::instances
