// Furniture made of boxes, and views of it rendered with noise, drift, occluders and wrong masks:
// worlds whose truth is known, for tests of registration and selection.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/core/random.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/render_voxels.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::testing_support {

// Voxels whose centre lies in the box, object units.
inline void FillBox(VoxelGrid& grid, const Eigen::Vector3d& min, const Eigen::Vector3d& max) {
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const Eigen::Vector3d center = VoxelGrid::Center(i, j, k);
        if ((center.array() >= min.array()).all() && (center.array() <= max.array()).all()) {
          grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
        }
      }
    }
  }
}

// Half of kModelExtent: the models below reach from -kHalf to kHalf in z.
inline constexpr double kHalf = 0.5 * kModelExtent;

inline void AddLegs(VoxelGrid& grid, double reach_x, double reach_y, double top) {
  for (const double x : {-reach_x, reach_x - 0.05}) {
    for (const double y : {-reach_y, reach_y - 0.05}) {
      FillBox(grid, {x, y, -kHalf}, {x + 0.05, y + 0.05, top});
    }
  }
}

// Faces +x: the back stands at -x.
inline VoxelGrid ChairGrid(double seat_height = 0.48, double half_width = 0.25) {
  VoxelGrid grid;
  const double seat = -kHalf + seat_height * kModelExtent;
  FillBox(grid, {-0.25, -half_width, seat - 0.05}, {0.25, half_width, seat});
  FillBox(grid, {-0.25, -half_width, seat}, {-0.19, half_width, kHalf});
  AddLegs(grid, 0.25, half_width, seat);
  return grid;
}

// The chair's hull as one block.
inline VoxelGrid BlockGrid() {
  VoxelGrid grid;
  FillBox(grid, {-0.25, -0.25, -kHalf}, {0.25, 0.25, kHalf});
  return grid;
}

inline VoxelGrid StoolGrid() {
  VoxelGrid grid;
  FillBox(grid, {-0.4, -0.4, kHalf - 0.1}, {0.4, 0.4, kHalf});
  AddLegs(grid, 0.4, 0.4, kHalf);
  return grid;
}

inline VoxelGrid TableGrid() {
  VoxelGrid grid;
  FillBox(grid, {-0.3, -kHalf, 0.20}, {0.3, kHalf, 0.25});
  for (const double x : {-0.3, 0.25}) {
    for (const double y : {-kHalf, kHalf - 0.05}) {
      FillBox(grid, {x, y, -0.25}, {x + 0.05, y + 0.05, 0.25});
    }
  }
  return grid;
}

// A disc on one column on a foot: nothing tells its yaw.
inline VoxelGrid RoundTableGrid() {
  VoxelGrid grid;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const Eigen::Vector3d center = VoxelGrid::Center(i, j, k);
        const double radius = center.head<2>().norm();
        const bool top = radius < kHalf && center.z() > 0.2 && center.z() < 0.26;
        const bool column = radius < 0.06 && std::abs(center.z()) < 0.26;
        const bool foot = radius < 0.25 && center.z() < -0.2 && center.z() > -0.26;
        if (top || column || foot) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
      }
    }
  }
  return grid;
}

inline VoxelGrid FullGrid() {
  VoxelGrid grid;
  std::fill(grid.occupied.begin(), grid.occupied.end(), std::uint8_t{1});
  return grid;
}

struct ViewSettings {
  double distance_m = 2.0;
  double height_m = 1.3;        // of the camera above the ground
  double noise_factor = 1.0;    // times a Kinect's axial noise
  double missing_share = 0.05;  // of the pixels
  double occluded_share = 0.0;  // of the image's lower part, hidden by something near
  double mask_error_px = 0.0;   // masks are shifted by this much, left or right, onto what is near
  double drift_m = 0.0;         // rms error of the tracked positions
  int side_px = 160;
};

// A world with z up, the ground z = 0, and one object.
class FurnitureWorld {
 public:
  // The object's model stands on the ground at the given place.
  FurnitureWorld(const VoxelGrid& grid,
                 double size_m,
                 double yaw_rad = 0.7,
                 const Eigen::Vector2d& place_m = {0.4, -0.3})
      : model_(grid) {
    world_from_object_.scale = size_m / kModelExtent;
    world_from_object_.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
    world_from_object_.translation_m = {
        place_m.x(), place_m.y(), -world_from_object_.scale * model_.bottom()};
  }

  [[nodiscard]] const shape::ShapeModel& model() const { return model_; }
  [[nodiscard]] const Similarity3& world_from_object() const { return world_from_object_; }

  // A camera at an azimuth of the world that looks at the object.
  [[nodiscard]] Pose3 WorldFromCamera(double azimuth_rad, const ViewSettings& settings) const {
    const Eigen::Vector3d target = world_from_object_.translation_m;
    const Eigen::Vector3d eye(target.x() + settings.distance_m * std::cos(azimuth_rad),
                              target.y() + settings.distance_m * std::sin(azimuth_rad),
                              settings.height_m);
    const Eigen::Vector3d forward = (target - eye).normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d rotation;
    rotation << right, forward.cross(right), forward;
    return {Eigen::Quaterniond(rotation), eye};
  }

  // The view as the tool would see it; its world_from_camera carries the drift.
  [[nodiscard]] ObjectView View(int index, double azimuth_rad, const ViewSettings& settings) const {
    Random random(17, "view", static_cast<std::uint64_t>(index));
    ObjectView view;
    view.detection = DetectionId{index};
    view.frame = FrameIdx{10 * index};
    view.detection_score = 0.8;
    const double focal = 0.55 * settings.side_px * settings.distance_m;
    view.camera = {settings.side_px,
                   settings.side_px,
                   focal,
                   focal,
                   0.5 * (settings.side_px - 1),
                   0.5 * (settings.side_px - 1)};
    const Pose3 world_from_camera = WorldFromCamera(azimuth_rad, settings);
    Render(world_from_camera, settings, random, view);
    view.ground_camera =
        Transformed(world_from_camera.Inverse(), Plane{Eigen::Vector3d::UnitZ(), 0});
    view.world_from_camera = world_from_camera;
    for (int axis = 0; axis < 3; ++axis) {
      view.world_from_camera.translation_m[axis] +=
          settings.drift_m / std::sqrt(3.0) * random.Normal();
    }
    return view;
  }

  [[nodiscard]] std::vector<ObjectView> Views(const std::vector<double>& azimuths_rad,
                                              const ViewSettings& settings = {}) const {
    std::vector<ObjectView> views;
    for (const double azimuth : azimuths_rad) {
      views.push_back(View(static_cast<int>(views.size()), azimuth, settings));
    }
    return views;
  }

 private:
  // Object, ground and a wall far behind.
  void Render(const Pose3& world_from_camera,
              const ViewSettings& settings,
              Random& random,
              ObjectView& view) const {
    const int side = settings.side_px;
    const DepthImage object =
        shape::RenderDepth(model_, world_from_camera.Inverse() * world_from_object_, view.camera);
    view.colour_crop = ColourImage(side, side);
    view.depth_crop_m = DepthImage(side, side);
    view.mask_crop = Mask(side, side);
    const int shift = static_cast<int>(settings.mask_error_px * (random.Uniform() < 0.5 ? -1 : 1));
    for (int v = 0; v < side; ++v) {
      for (int u = 0; u < side; ++u) {
        const Eigen::Vector3d ray = world_from_camera.rotation * view.camera.Ray(u, v);
        double depth = 6.0;
        if (ray.z() < 0) depth = std::min(depth, -world_from_camera.translation_m.z() / ray.z());
        const bool on_object = object(u, v) > 0;
        if (on_object) depth = object(u, v);
        const bool hidden = v > (1.0 - settings.occluded_share) * side;
        if (hidden) depth = 0.5 * settings.distance_m;
        const double beyond = depth - 0.4;
        const double sigma = 0.0012 + 0.0019 * beyond * beyond;
        const bool missing = random.Uniform() < settings.missing_share;
        const double noise = settings.noise_factor * sigma * random.Normal();
        if (missing) continue;
        view.depth_crop_m(u, v) = static_cast<float>(depth + noise);
        const double height = world_from_camera.translation_m.z() + depth * ray.z();
        if (!on_object || hidden || height < 0.03) continue;
        if (view.mask_crop.Contains(u + shift, v)) view.mask_crop(u + shift, v) = 1;
      }
    }
    // Segments are connected in space: however wrong a mask, it does not reach the wall far behind.
    const double farthest = settings.distance_m + world_from_object_.scale;
    for (int v = 0; v < side; ++v) {
      for (int u = 0; u < side; ++u) {
        if (view.depth_crop_m(u, v) > farthest) view.mask_crop(u, v) = 0;
      }
    }
  }

  shape::ShapeModel model_;
  Similarity3 world_from_object_;
};

// A chair at 2 m as Kinect-like cameras see it, from three quarters of the way round.
inline std::vector<ObjectView> ViewsAround(const FurnitureWorld& world, int num_views) {
  ViewSettings settings;
  settings.side_px = 240;
  std::vector<double> azimuths_rad;
  for (int n = 0; n < num_views; ++n)
    azimuths_rad.push_back(1.5 * std::numbers::pi * n / num_views);
  return world.Views(azimuths_rad, settings);
}

inline ShapeCandidate CandidateFor(double min_size_m,
                                   double max_size_m,
                                   double size_m = 0,
                                   int id = 0) {
  ShapeCandidate candidate;
  candidate.id = CandidateId{id};
  candidate.object = ObjectId{0};
  candidate.view = DetectionId{0};
  candidate.model = "model";
  candidate.size_m = size_m;
  candidate.min_size_m = min_size_m;
  candidate.max_size_m = max_size_m;
  return candidate;
}

// 5 cm beside, 5 deg turned, and larger or smaller; the bottom leaves the ground with the scale.
inline Similarity3 Perturbed(Similarity3 world_from_object, double scale_factor, double towards) {
  world_from_object.scale *= scale_factor;
  world_from_object.translation_m +=
      0.05 * Eigen::Vector3d(std::cos(towards), std::sin(towards), 0);
  world_from_object.rotation =
      Eigen::AngleAxisd(5 * std::numbers::pi / 180, Eigen::Vector3d::UnitZ()) *
      world_from_object.rotation;
  return world_from_object;
}

// A registration that places the model alike in all views.
inline CandidateRegistration PlacedAt(const Similarity3& world_from_object,
                                      const std::vector<ObjectView>& views,
                                      int candidate = 0) {
  CandidateRegistration registration;
  registration.candidate = CandidateId{candidate};
  registration.ok = true;
  registration.scale_m = world_from_object.scale;
  registration.world_from_object = world_from_object.RigidPart();
  for (const ObjectView& view : views) {
    ViewRegistration& entry = registration.views.emplace_back();
    entry.view = view.detection;
    entry.frame = view.frame;
    entry.ok = true;
    entry.camera_from_object = view.world_from_camera.Inverse() * world_from_object.RigidPart();
  }
  return registration;
}

}  // namespace deepslam::testing_support
