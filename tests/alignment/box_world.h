// An analytic room of boxes, ray-cast into colour and depth: the same scene makes the frames and
// the truth. World: z up, floor z = 0. Everything has a smooth texture that is a function of the
// surface point.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/core/random.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::testing_support {

inline const PinholeCamera kSmallCamera{160, 120, 131, 131, 79.5, 59.5};

// World from a camera at `eye` that looks at `target`, upright, then rolled about its optical axis.
inline Pose3 LookAt(const Eigen::Vector3d& eye,
                    const Eigen::Vector3d& target,
                    double roll_rad = 0) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation << right, forward.cross(right), forward;
  return {Eigen::Quaterniond(rotation * Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()))
              .normalized(),
          eye};
}

struct BoxWorld {
  Box3 room{{-2, -2, 0}, {2, 2, 2.5}};  // seen from inside
  std::vector<Box3> boxes;              // seen from outside
  std::vector<Box3> walker;             // boxes that move, texture and all ...
  Eigen::Vector3d walked_m{0, 0, 0};    // ... by this far
  double texture = 1;                   // contrast, 0 to 1
  double texture_fineness = 1;          // how many times smaller than in other worlds
  double texture_phase = 0;             // another world's texture
  double floor_darker = 0;              // grey levels, of the floor against everything else
  double grain_greys = 0;               // of paint, in grains of 2 cm
  double tile_m =
      0;  // above 0: everything is tiled, tiles a little lighter or darker than each other

  static BoxWorld Furnished() {
    BoxWorld world;
    world.boxes = {{{0.2, -0.4, 0}, {0.9, 0.4, 0.7}},
                   {{-0.9, 0.5, 0}, {-0.4, 1.1, 1.2}},
                   {{0.9, 1.0, 0}, {1.6, 1.6, 0.45}},
                   {{-1.2, -1.3, 0}, {-0.6, -0.7, 0.9}},
                   {{1.3, -1.6, 0}, {1.9, -0.9, 1.7}}};
    return world;
  }

  // One flat wall in front of the camera of Pose3{} (at z = 2 of the camera), nothing else within
  // reach.
  static BoxWorld Wall() {
    BoxWorld world;
    world.room = {{-50, -50, -50}, {50, 50, 2}};
    return world;
  }

  // Distance along the ray to the nearest surface, in units of the direction's length.
  [[nodiscard]] double Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    double nearest = Exit(room, origin, direction);
    for (const Box3& box : boxes) nearest = std::min(nearest, Entry(box, origin, direction));
    return std::min(nearest, CastWalker(origin, direction));
  }

  [[nodiscard]] double CastWalker(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Box3& part : walker)
      nearest = std::min(nearest, Entry(part, origin - walked_m, direction));
    return nearest;
  }

  [[nodiscard]] double Intensity(const Eigen::Vector3d& p) const {
    if (tile_m > 0) return TileIntensity(p / tile_m);
    const Eigen::Vector3d q = texture_fineness * (OnWalker(p) ? p - walked_m : p);
    const double a = std::sin(9.1 * q.x() + 3.7 * q.y() + 1.3 * q.z() + texture_phase) *
                     std::sin(2.3 * q.x() - 7.9 * q.y() + 5.1 * q.z() + 2 * texture_phase);
    const double b = std::sin(3.1 * q.x() + 4.3 * q.y() - 8.7 * q.z() + 0.5);
    const double shade = p.z() < room.min.z() + 1e-6 ? floor_darker : 0;
    return std::clamp(128 - shade + texture * (60 * a + 40 * b) + Grain(p), 0.0, 255.0);
  }

 private:
  [[nodiscard]] double Grain(const Eigen::Vector3d& p) const {
    if (!(grain_greys > 0)) return 0;
    std::uint64_t hash = 1;
    for (int k = 0; k < 3; ++k) {
      hash ^= static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(p[k] / 0.02 + 0.37)));
      hash *= 0x9E3779B97F4A7C15ULL;
      hash ^= hash >> 29;
    }
    return grain_greys * (static_cast<double>(hash >> 40) / (1 << 23) - 1);
  }

  [[nodiscard]] bool OnWalker(const Eigen::Vector3d& p) const {
    const Eigen::Array3d q = p - walked_m;
    return std::ranges::any_of(walker, [&](const Box3& part) {
      return (q > part.min.array() - 1e-6).all() && (q < part.max.array() + 1e-6).all();
    });
  }

  [[nodiscard]] double TileIntensity(const Eigen::Vector3d& p_tiles) const {
    constexpr double kJoint = 0.05;
    // Surfaces lie on multiples of the tile only by chance: a little off, they are in one tile.
    const Eigen::Array3d at = p_tiles.array() + 0.013;
    const Eigen::Array3d tile = at.floor();
    const bool joint = ((at - tile) < kJoint).any();
    const double shade = std::sin(12.9 * tile.x() + 78.2 * tile.y() + 37.7 * tile.z());
    return std::clamp(128 + texture * (joint ? -40.0 : 12 * shade), 0.0, 255.0);
  }

  static double Exit(const Box3& box,
                     const Eigen::Vector3d& origin,
                     const Eigen::Vector3d& direction) {
    double exit = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      if (direction[k] > 0) exit = std::min(exit, (box.max[k] - origin[k]) / direction[k]);
      if (direction[k] < 0) exit = std::min(exit, (box.min[k] - origin[k]) / direction[k]);
    }
    return exit;
  }

  static double Entry(const Box3& box,
                      const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& direction) {
    double enter = 0;
    double leave = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const double inverse = 1 / (direction[k] == 0 ? 1e-12 : direction[k]);
      const double a = (box.min[k] - origin[k]) * inverse;
      const double b = (box.max[k] - origin[k]) * inverse;
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter > 0 && enter < leave ? enter : std::numeric_limits<double>::infinity();
  }
};

// `noise` scales the depth noise of a structured-light camera (Nguyen et al. 2012); 0 is exact
// depth. Depth beyond 8 m is invalid.
inline Frame RenderFrame(const BoxWorld& world,
                         const Pose3& world_from_camera,
                         double noise = 0,
                         std::uint64_t seed = 0,
                         const PinholeCamera& camera = kSmallCamera) {
  Frame frame;
  frame.depth_m = DepthImage(camera.width, camera.height);
  frame.colour = ColourImage(camera.width, camera.height);
  Random random(seed, "render", 0);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d direction = world_from_camera.rotation * camera.Ray(u, v);
      const double depth = world.Cast(world_from_camera.translation_m, direction);
      const double grey = world.Intensity(world_from_camera.translation_m + depth * direction);
      const auto level = static_cast<std::uint8_t>(grey);
      frame.colour(u, v) = {level, level, level};
      const double sigma = noise * (0.0012 + 0.0019 * (depth - 0.4) * (depth - 0.4));
      const double measured = noise > 0 ? depth + sigma * random.Normal() : depth;
      frame.depth_m(u, v) = measured > 0.1 && measured < 8 ? static_cast<float>(measured) : 0.0F;
    }
  }
  return frame;
}

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;

// Camera carried along an arc through the room; `step_deg` of it per frame.
inline std::vector<Pose3> Arc(int num_frames, double step_deg = 2.0) {
  std::vector<Pose3> poses;
  for (int k = 0; k < num_frames; ++k) {
    const double angle = (200 + step_deg * k) * kRadPerDeg;
    poses.push_back(
        LookAt({1.5 * std::cos(angle), 1.5 * std::sin(angle), 1.3 + 0.004 * k}, {0.2, 0.1, 0.5}));
  }
  return poses;
}

inline std::vector<Frame> Render(const BoxWorld& world,
                                 const std::vector<Pose3>& poses,
                                 double noise = 1.0) {
  std::vector<Frame> frames;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    frames.push_back(RenderFrame(world, poses[k], noise, k));
    frames.back().time_s = 0.05 * static_cast<double>(k);
  }
  return frames;
}

}  // namespace deepslam::testing_support
