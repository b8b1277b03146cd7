// Depth views of a voxel model before a wall, without noise.
#pragma once

#include <cmath>

#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/shape/render_voxels.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::testing_support {

inline constexpr double kStagedSizeM = 0.8;  // metres per object unit
inline constexpr float kStagedWallM = 6;

struct Staged {
  ObjectView view;
  Similarity3 camera_from_grid;
};

// A camera that looks at the model's middle from `azimuth_rad` about its vertical and
// `elevation_rad` above it.
inline Staged LookAt(const shape::ShapeModel& model, double azimuth_rad, double elevation_rad = 0) {
  Staged staged;
  Eigen::Matrix3d rotation;  // rows: right, down, forward of the camera in the object's axes
  const double level = std::cos(elevation_rad);
  const Eigen::Vector3d forward(
      -level * std::cos(azimuth_rad), -level * std::sin(azimuth_rad), -std::sin(elevation_rad));
  const Eigen::Vector3d right(-std::sin(azimuth_rad), std::cos(azimuth_rad), 0);
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  staged.camera_from_grid = {kStagedSizeM, Eigen::Quaterniond(rotation), {0, 0, 2}};
  ObjectView& view = staged.view;
  view.camera = {240, 240, 400, 400, 119.5, 119.5};
  view.depth_crop_m = shape::RenderDepth(model, staged.camera_from_grid, view.camera);
  view.mask_crop = Mask(240, 240);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 240; ++u) {
      view.mask_crop(u, v) = view.depth_crop_m(u, v) > 0 ? 1 : 0;
      if (view.mask_crop(u, v) == 0) view.depth_crop_m(u, v) = kStagedWallM;
    }
  }
  return staged;
}

}  // namespace deepslam::testing_support
