#include "deepslam/eval/silhouette.h"

#include "deepslam/core/check.h"
#include "deepslam/shape/rasterise_depth.h"

namespace deepslam::eval {

SilhouetteOverlap CompareSilhouette(const TriangleMesh& mesh,
                                    const Pose3& camera_from_mesh,
                                    const PinholeCamera& camera,
                                    const Mask& mask,
                                    const DepthImage& depth_m,
                                    const SilhouetteOptions& options) {
  DEEPSLAM_CHECK(mask.width() == camera.width && mask.height() == camera.height &&
                     depth_m.width() == camera.width && depth_m.height() == camera.height,
                 "mask, depth and camera have one size");
  const DepthImage model_m = shape::RasteriseDepth(mesh, camera_from_mesh, camera);
  SilhouetteOverlap overlap;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto model = static_cast<double>(model_m(u, v));
      const auto measured = static_cast<double>(depth_m(u, v));
      const bool in_mask = mask(u, v) != 0;
      const double margin_m = options.occlusion_margin_m + options.occlusion_margin_share * model;
      if (model > 0 && !in_mask && measured > 0 && measured < model - margin_m) {
        ++overlap.num_occluded;
        continue;
      }
      if (options.leave_out_unmeasured && measured <= 0 && !in_mask) continue;
      overlap.num_model += model > 0 ? 1 : 0;
      overlap.num_mask += in_mask ? 1 : 0;
      overlap.num_both += model > 0 && in_mask ? 1 : 0;
    }
  }
  const int either = overlap.num_model + overlap.num_mask - overlap.num_both;
  overlap.iou = either > 0 ? static_cast<double>(overlap.num_both) / either : 0.0;
  return overlap;
}

}  // namespace deepslam::eval
