// Agreement of a mapped object's outline with what was segmented in a frame, where no truth is
// known.
#pragma once

#include <string_view>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::eval {

inline constexpr std::string_view kSilhouetteProtocol =
    "silhouettes: IoU of the projected object with its segment, per view, median; pixels that "
    "something nearer hides say nothing, nor do those without depth but in all_px";

struct SilhouetteOptions {
  // A measured depth this much nearer than the model hides it there, so the pixel says nothing;
  // metres plus share of depth.
  double occlusion_margin_m = 0.05;
  double occlusion_margin_share = 0.02;
  // Segments hold pixels with depth alone. Where the sensor measured none, a pixel of the model
  // tells of the sensor (dark or shiny surfaces), not of the fit: with this it says nothing either.
  bool leave_out_unmeasured = false;
};

struct SilhouetteOverlap {
  int num_model = 0;  // pixels of the projected model, hidden ones left out
  int num_mask = 0;   // pixels of the segment, left-out ones not counted
  int num_both = 0;
  int num_occluded =
      0;           // pixels of the model that something nearer hides and the segment does not hold
  double iou = 0;  // num_both / (num_model + num_mask - num_both); 0 when both are empty
};

// Pixels outside the image are left out by the camera's size; crops are cameras with a moved
// principal point. `mask`, `depth_m` and the camera have one size.
SilhouetteOverlap CompareSilhouette(const TriangleMesh& mesh,
                                    const Pose3& camera_from_mesh,
                                    const PinholeCamera& camera,
                                    const Mask& mask,
                                    const DepthImage& depth_m,
                                    const SilhouetteOptions& options = {});

}  // namespace deepslam::eval
