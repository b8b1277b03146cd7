// Rooms of cuboids with cameras in them, as coarse surfaces.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "deepslam/fuse/coarse_fusion.h"
#include "deepslam/scene/coarse_surface.h"
#include "support/box_world.h"

namespace deepslam::layout {

using testing_support::Cuboid;

inline constexpr double kCeiling_m = 2.5;

inline void AddBox(const Eigen::Vector3d& min_m,
                   const Eigen::Vector3d& max_m,
                   std::vector<Cuboid>& world) {
  world.push_back({-1, min_m, max_m});
}

// A hole in a wall: where along it, and between which heights.
struct Hole {
  double from_m = 0;
  double to_m = 0;
  double bottom_m = 0;
  double top_m = 2.0;
};

// A wall along x (or y) from floor to ceiling but for its holes, one face at `at_m`, the other
// `thickness_m` from it (which may be negative).
struct WallSpec {
  bool along_x = true;
  double at_m = 0;
  double from_m = 0;
  double to_m = 0;
  double thickness_m = 0.2;
  std::vector<Hole> holes = {};
};

inline void AddWall(const WallSpec& wall, std::vector<Cuboid>& world) {
  const double low = std::min(wall.at_m, wall.at_m + wall.thickness_m);
  const double high = std::max(wall.at_m, wall.at_m + wall.thickness_m);
  const auto add = [&](double from, double to, double bottom, double top) {
    if (to <= from || top <= bottom) return;
    if (wall.along_x) {
      AddBox({from, low, bottom}, {to, high, top}, world);
    } else {
      AddBox({low, from, bottom}, {high, to, top}, world);
    }
  };
  double at = wall.from_m;
  for (const Hole& hole : wall.holes) {
    add(at, hole.from_m, 0, kCeiling_m);
    add(hole.from_m, hole.to_m, 0, hole.bottom_m);
    add(hole.from_m, hole.to_m, hole.top_m, kCeiling_m);
    at = hole.to_m;
  }
  add(at, wall.to_m, 0, kCeiling_m);
}

inline void AddCeiling(double x0, double y0, double x1, double y1, std::vector<Cuboid>& world) {
  AddBox({x0, y0, kCeiling_m}, {x1, y1, kCeiling_m + 0.2}, world);
}

// Four walls around [x0, x1] x [y0, y1], without holes.
inline void AddRoomWalls(double x0, double y0, double x1, double y1, std::vector<Cuboid>& world) {
  AddWall({true, y1, x0 - 0.2, x1 + 0.2, 0.2, {}}, world);
  AddWall({true, y0, x0 - 0.2, x1 + 0.2, -0.2, {}}, world);
  AddWall({false, x1, y0 - 0.2, y1 + 0.2, 0.2, {}}, world);
  AddWall({false, x0, y0 - 0.2, y1 + 0.2, -0.2, {}}, world);
}

// A camera that turns once round at a place, looking a little down, level and a little up.
inline void LookAround(double x, double y, std::vector<Pose3>& poses, int num_turns = 10) {
  for (int n = 0; n < num_turns; ++n) {
    const double angle = 2 * std::numbers::pi * n / num_turns;
    for (const double target_m : {0.6, 1.5, 2.4}) {
      poses.push_back(testing_support::LookAt(
          {x, y, 1.5}, {x + 1.5 * std::cos(angle), y + 1.5 * std::sin(angle), target_m}));
    }
  }
}

// The world turned about the vertical, as cameras at these poses in it see it.
inline CoarseSurface SurfaceOf(const std::vector<Cuboid>& world,
                               const std::vector<Pose3>& poses,
                               double turned_rad = 0) {
  const Pose3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitZ())),
                   Eigen::Vector3d::Zero()};
  const PinholeCamera camera = testing_support::SmallCamera();
  fuse::CoarseFusion fusion{fuse::CoarseOptions()};
  for (std::size_t n = 0; n < poses.size(); ++n) {
    const Frame frame =
        testing_support::RenderBoxes(world, camera, poses[n], {static_cast<int>(n)}).frame;
    static_cast<void>(fusion.Integrate(frame, camera, turn * poses[n]));
  }
  CoarseSurface surface = std::move(fusion).Take();
  surface.has_ground = true;
  return surface;
}

}  // namespace deepslam::layout
