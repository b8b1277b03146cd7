#include "deepslam/discovery/best_views.h"

#include <algorithm>
#include <cstddef>

#include "deepslam/geometry/pixel_box.h"

namespace deepslam::discovery {

std::vector<Look> LooksIn(FrameIdx frame,
                          const instances::VotingView& view,
                          const instances::SurfaceElements& elements,
                          const instances::Instances& found,
                          const instances::VoteOptions& options) {
  std::vector<Look> looks(found.instances.size());
  const instances::VisibleElements visible = instances::FindVisible(elements, view, options);
  for (std::size_t n = 0; n < visible.elements.size(); ++n) {
    const auto element = static_cast<std::size_t>(visible.elements[n]);
    if (found.of_element[element] < 0) continue;
    Look& look = looks[static_cast<std::size_t>(found.of_element[element])];
    const Eigen::Vector2i& pixel = visible.pixels[n];
    look.seen.frame = frame;
    ExtendByPixel(pixel.x(), pixel.y(), look.seen.box_px);
    const double z_m = (view.camera_from_level * elements.points()[element].cast<double>()).z();
    const double side_px = view.camera.fx * elements.voxel_m() / z_m;
    look.area_px += side_px * side_px;
  }
  return looks;
}

void KeepBest(std::span<const Look> looks, std::vector<Look>& best) {
  best.resize(std::max(best.size(), looks.size()));
  for (std::size_t thing = 0; thing < looks.size(); ++thing) {
    if (looks[thing].area_px > best[thing].area_px) best[thing] = looks[thing];
  }
}

}  // namespace deepslam::discovery
