#include "deepslam/propose/front_of_box.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "deepslam/geometry/facing.h"
#include "deepslam/scene/sides_at_walls.h"

namespace deepslam::propose {
namespace {

// Screens, mirrors and shelves are thinner, and their wide sides are front and back; of beds, seats
// and tables neither side is.
constexpr double kThin = 0.4;  // of the wider side
// What speaks against a front, in units of facing away from all cameras. Each outweighs what stands
// below it: thinness and backs are the thing's own shape, walls say where furniture may stand, and
// cameras pass on all sides of it.
constexpr double kNarrowCost = 6;
constexpr double kNotBeforeBackCost = 3;  // more than a wall and all cameras together
constexpr double kBlockedCost = 1.5;      // by a wall wholly: more than all cameras
// Of a front narrower than the thing is deep, by the log of their ratio: in a corner furniture
// stands with its long side at the wall. A toilet's, half of its depth, costs less than a wall at
// its side.
constexpr double kDeepCost = 1;

double ProportionCost(const LevelBox& box, int side) {
  const double depth_m = side % 2 == 0 ? box.size_m.x() : box.size_m.y();
  const double width_m = side % 2 == 0 ? box.size_m.y() : box.size_m.x();
  if (width_m < kThin * depth_m) return kNarrowCost;
  return kDeepCost * std::max(0.0, std::log(depth_m / std::max(width_m, 1e-6)));
}

}  // namespace

int QuarterTurnsToFront(const LevelBox& box,
                        const Pose3& level_from_world,
                        const FrontEvidence& evidence) {
  const Pose3 level_from_box(
      Eigen::Quaterniond(Eigen::AngleAxisd(box.yaw_rad, Eigen::Vector3d::UnitZ())),
      {box.center_m.x(), box.center_m.y(), 0.5 * box.size_m.z()});
  const Pose3 world_from_box = level_from_world.Inverse() * level_from_box;
  SidesAtWalls at_walls = {};
  if (evidence.layout != nullptr) {
    at_walls = FindSidesAtWalls(
        *evidence.layout, evidence.layout->level_from_tracking * world_from_box, box.size_m);
  }
  std::vector<Eigen::Vector3d> cameras_world;
  for (const ObjectView& view : evidence.views)
    cameras_world.push_back(view.world_from_camera.translation_m);
  int best = 0;
  double least = 0;
  for (int side = 0; side < 4; ++side) {
    const int turns = (4 - side) % 4;
    const Eigen::Quaterniond box_from_object(
        Eigen::AngleAxisd(0.5 * std::numbers::pi * side, Eigen::Vector3d::UnitZ()));
    double cost = BackShown(
        world_from_box.rotation * box_from_object, world_from_box.translation_m, cameras_world);
    cost += ProportionCost(box, side);
    if (evidence.turns_from_high_back.value_or(turns) != turns) cost += kNotBeforeBackCost;
    cost += kBlockedCost * FrontBlocked(at_walls, side);
    if (side > 0 && cost >= least) continue;
    best = turns;
    least = cost;
  }
  return best;
}

}  // namespace deepslam::propose
