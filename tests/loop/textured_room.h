// A room with a blocky texture on everything, ray cast exactly: the same scene makes images and
// truth. World: z up, floor z = 0.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/random.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::loop::testing_support {

inline const PinholeCamera kCamera{320, 240, 260, 260, 159.5, 119.5};

struct TexturedRoom {
  Box3 room{{-3, -2.5, 0}, {3, 2.5, 2.6}};  // seen from inside
  std::vector<Box3> boxes = {{{0.4, -0.4, 0}, {1.0, 0.4, 0.7}},
                             {{-1.2, 0.6, 0}, {-0.6, 1.2, 1.2}},
                             {{-1.9, -1.6, 0}, {-1.2, -1.0, 0.9}}};
  std::uint64_t seed = 1;
  double block_m = 0.12;
  // Above 0: the texture repeats after so many blocks in all directions.
  int period = 0;
  double contrast = 1;

  [[nodiscard]] double Cast(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (ray[axis] == 0) continue;
      const double wall = ray[axis] > 0 ? room.max[axis] : room.min[axis];
      nearest = std::min(nearest, (wall - eye[axis]) / ray[axis]);
    }
    for (const Box3& box : boxes) nearest = std::min(nearest, Entry(box, eye, ray));
    return nearest;
  }

  [[nodiscard]] std::uint8_t Intensity(const Eigen::Vector3d& p) const {
    std::uint64_t cell = 0;
    for (int axis = 0; axis < 3; ++axis) {
      // Off the walls, which lie at round numbers.
      auto k = static_cast<std::int64_t>(std::floor((p[axis] + 50.0371) / block_m));
      if (period > 0) k %= period;
      cell = 1000 * cell + static_cast<std::uint64_t>(k);
    }
    const double level = Random(seed, "texture", cell).Uniform(-100, 100);
    return static_cast<std::uint8_t>(128 + contrast * level);
  }

 private:
  static double Entry(const Box3& box, const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    double near = 1e-6;
    double far = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double inverse = 1.0 / (ray[axis] == 0 ? 1e-300 : ray[axis]);
      const double a = (box.min[axis] - eye[axis]) * inverse;
      const double b = (box.max[axis] - eye[axis]) * inverse;
      near = std::max(near, std::min(a, b));
      far = std::min(far, std::max(a, b));
    }
    return near <= far ? near : std::numeric_limits<double>::infinity();
  }
};

inline Pose3 Looking(const Eigen::Vector3d& eye, double yaw_rad, double down_rad = 0.25) {
  Eigen::Matrix3d axes;
  axes.col(2) = Eigen::Vector3d(std::cos(down_rad) * std::cos(yaw_rad),
                                std::cos(down_rad) * std::sin(yaw_rad),
                                -std::sin(down_rad));
  axes.col(0) = axes.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {Eigen::Quaterniond(axes).normalized(), eye};
}

inline Frame Photograph(const TexturedRoom& room, const Pose3& world_from_camera, int idx) {
  Frame frame;
  frame.idx = FrameIdx{idx};
  frame.colour = ColourImage(kCamera.width, kCamera.height);
  frame.depth_m = DepthImage(kCamera.width, kCamera.height);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const Eigen::Vector3d ray = world_from_camera.rotation * kCamera.Ray(u, v);
      const double depth_m = room.Cast(world_from_camera.translation_m, ray);
      const std::uint8_t grey = room.Intensity(world_from_camera.translation_m + depth_m * ray);
      frame.colour(u, v) = {grey, grey, grey};
      frame.depth_m(u, v) = static_cast<float>(depth_m);
    }
  }
  return frame;
}

// Round the room's middle, looking outwards; `laps` above 1 comes back to the beginning.
inline std::vector<Pose3> Round(int num_keyframes, double laps) {
  std::vector<Pose3> poses;
  for (int k = 0; k < num_keyframes; ++k) {
    const double angle = 2 * std::numbers::pi * laps * k / (num_keyframes - 1);
    poses.push_back(Looking({0.6 * std::cos(angle), 0.5 * std::sin(angle), 1.4}, angle, 0.3));
  }
  return poses;
}

// Every frame a keyframe, tracked as given.
inline Odometry Tracked(const std::vector<Pose3>& world_from_camera) {
  Odometry odometry;
  for (const Pose3& pose : world_from_camera) {
    const FrameIdx frame{static_cast<int>(odometry.frames.size())};
    odometry.frames.push_back({frame, 0.1 * frame.value, pose, TrackingStatus::kTracked, frame});
    odometry.keyframes.push_back(frame);
    if (frame.value == 0) continue;
    const FrameIdx before{frame.value - 1};
    odometry.edges.push_back(
        {before, frame, odometry.at(before).world_from_camera.Inverse() * pose});
  }
  return odometry;
}

}  // namespace deepslam::loop::testing_support
