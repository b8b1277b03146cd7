// The part of a frame that is of a thing: its silhouette, whatever detections said there.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/options.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/instances/find_instances.h"
#include "deepslam/instances/pixel_labels.h"
#include "deepslam/scene/detection.h"

namespace deepslam::instances {

struct SilhouetteOptions {
  double max_depth_m = 5;          // farther depth is not used
  int min_points = 400;            // silhouettes with fewer pixels are no view
  double min_visible_share = 0.1;  // nor those that show a smaller share of the thing's surface
  double border_margin_px = 8;     // one nearer to the image border touches it
  double fill_gap_m = 0.15;  // gaps without depth up to this width inside a thing belong to it
};
void Describe(OptionsVisitor& visitor, SilhouetteOptions& options);

struct Silhouette {
  int instance = -1;  // index
  Box2 box_px;
  Mask mask;           // size of the image; 1 = the thing, with or without depth
  int num_points = 0;  // pixels with depth
  Box3 extent_camera;
  bool touches_border = false;
};

// Points, box and extent of what its mask holds.
void FitToMask(const DepthImage& depth_m, const PinholeCamera& camera, Silhouette& silhouette);

// Of every instance that is not rejected and enough of which lies in the frame, ascending. Masks do
// not overlap. `shown`: what detections with masks show in this frame.
[[nodiscard]] std::vector<Silhouette> FindSilhouettes(const DividedSurface& surface,
                                                      std::span<const ShownInstance> shown,
                                                      const DepthImage& depth_m,
                                                      const PinholeCamera& camera,
                                                      const Pose3& level_from_camera,
                                                      const SilhouetteOptions& options);

}  // namespace deepslam::instances
