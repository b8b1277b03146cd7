// Views of a voxel model standing on a floor, as a perfect (or noisy) RGB-D camera and segmentation
// would give them.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "deepslam/core/random.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/shape/render_voxels.h"

namespace deepslam::testing_support {

struct Stage {
  double size_m = 1;  // longest side of the model
  double yaw_rad = 0.4;
  Eigen::Vector2d place_m = {0.3, -0.2};
  int num_views = 6;
  double first_azimuth_rad = 0;  // of the cameras, about the object
  double sweep_rad = 2.5;
  double distance_m = 2.0;
  double height_m = 1.4;
  double noise_m = 0;  // of the depth at 1 m, growing with the square
  bool has_ground = true;
  // How the camera is turned out of looking at the model: about its y, its x, its own axis.
  Eigen::Vector3d turned_rad = Eigen::Vector3d::Zero();
};

inline Pose3 LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - eye).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation << x, z.cross(x), z;
  return {Eigen::Quaterniond(rotation), eye};
}

// The world of the poses is turned against the floor, as a tracking world is.
inline Pose3 StagedWorldFromLevel() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(1.9, Eigen::Vector3d(1, 0.1, -0.2).normalized())),
          {0.5, 1.0, -0.7}};
}

inline Similarity3 StagedLevelFromObject(const shape::ShapeModel& model, const Stage& stage) {
  const double scale = stage.size_m / kModelExtent;
  return {scale,
          Eigen::Quaterniond(Eigen::AngleAxisd(stage.yaw_rad, Eigen::Vector3d::UnitZ())),
          {stage.place_m.x(), stage.place_m.y(), -scale * model.bottom()}};
}

inline std::vector<ObjectView> StagedViews(const VoxelGrid& grid, const Stage& stage) {
  const shape::ShapeModel model(grid);
  const Similarity3 level_from_object = StagedLevelFromObject(model, stage);
  const Pose3 world_from_level = StagedWorldFromLevel();
  Random random(11, "staged views", 0);
  std::vector<ObjectView> views;
  for (int n = 0; n < stage.num_views; ++n) {
    const double azimuth =
        stage.first_azimuth_rad + stage.sweep_rad * n / std::max(1, stage.num_views - 1);
    const Eigen::Vector3d target(stage.place_m.x(), stage.place_m.y(), 0.4);
    const Eigen::Vector3d eye(stage.place_m.x() + stage.distance_m * std::cos(azimuth),
                              stage.place_m.y() + stage.distance_m * std::sin(azimuth),
                              stage.height_m);
    Pose3 level_from_camera = LookAt(eye, target);
    level_from_camera.rotation = level_from_camera.rotation *
                                 Eigen::AngleAxisd(stage.turned_rad.x(), Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(stage.turned_rad.y(), Eigen::Vector3d::UnitX()) *
                                 Eigen::AngleAxisd(stage.turned_rad.z(), Eigen::Vector3d::UnitZ());
    ObjectView view;
    view.detection = DetectionId{n};
    view.frame = FrameIdx{n};
    view.detection_score = 0.8;
    view.camera = {200, 180, 180, 180, 99.5, 89.5};
    view.world_from_camera = world_from_level * level_from_camera;
    const Plane floor_camera = Transformed(level_from_camera.Inverse(), Plane{});
    if (stage.has_ground) view.ground_camera = floor_camera;
    view.depth_crop_m =
        shape::RenderDepth(model, level_from_camera.Inverse() * level_from_object, view.camera);
    view.colour_crop = ColourImage(view.camera.width, view.camera.height);
    view.mask_crop = Mask(view.camera.width, view.camera.height, 0);
    for (int v = 0; v < view.camera.height; ++v) {
      for (int u = 0; u < view.camera.width; ++u) {
        float& depth_m = view.depth_crop_m(u, v);
        view.mask_crop(u, v) = depth_m > 0 ? 1 : 0;
        if (depth_m == 0) {
          const double toward = floor_camera.normal.dot(view.camera.Ray(u, v));
          if (toward < -1e-3) depth_m = static_cast<float>(-floor_camera.d_m / toward);
        }
        if (depth_m > 0 && stage.noise_m > 0) {
          depth_m += static_cast<float>(stage.noise_m * depth_m * depth_m * random.Normal());
        }
      }
    }
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace deepslam::testing_support
