#include "deepslam/layout/relations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deepslam::layout {
namespace {

constexpr double kTouching_m = 0.10;   // between what stands and what it stands on: feet, noise
constexpr double kAtWall_m = 0.15;     // between a wall and what stands at it: skirting, cables
constexpr double kIntoWall_m = -0.15;  // boxes are larger than things
constexpr double kAlong = 0.94;        // cosine of 20 deg between a side and the wall
constexpr double kHanging_m = 0.3;     // what hangs on a wall is this far above the floor

struct Footprint {
  std::array<Eigen::Vector2d, 4> corners_m;
  Eigen::Vector2d middle_m;
  double bottom_m = 0;
  double top_m = 0;
  Eigen::Vector2d x_axis;
};

Footprint FootprintOf(const ThingBox& thing) {
  Footprint print;
  print.middle_m = thing.world_from_object.translation_m.head<2>();
  const Eigen::Vector3d half = thing.size_m / 2;
  for (std::size_t n = 0; n < 4; ++n) {
    const Eigen::Vector3d corner(
        (n & 1U) != 0 ? half.x() : -half.x(), (n & 2U) != 0 ? half.y() : -half.y(), 0);
    print.corners_m[n] = (thing.world_from_object * corner).head<2>();
  }
  print.bottom_m = thing.world_from_object.translation_m.z() - half.z();
  print.top_m = thing.world_from_object.translation_m.z() + half.z();
  print.x_axis =
      (thing.world_from_object.rotation * Eigen::Vector3d::UnitX()).head<2>().normalized();
  return print;
}

bool Holds(const ThingBox& thing, const Eigen::Vector2d& p) {
  const Eigen::Vector3d at(p.x(), p.y(), thing.world_from_object.translation_m.z());
  const Eigen::Vector3d p_object = thing.world_from_object.Inverse() * at;
  return std::abs(p_object.x()) <= thing.size_m.x() / 2 &&
         std::abs(p_object.y()) <= thing.size_m.y() / 2;
}

std::optional<int> RoomOf(const Layout& layout, const Footprint& print) {
  for (std::size_t room = 0; room < layout.rooms.size(); ++room) {
    if (IsInside(layout.rooms[room].polygon_m, print.middle_m)) return static_cast<int>(room);
  }
  return std::nullopt;
}

std::optional<int> WallAt(const Layout& layout, const Footprint& print) {
  std::optional<int> nearest;
  double nearest_m = kAtWall_m;
  for (std::size_t n = 0; n < layout.walls.size(); ++n) {
    const LayoutWall& wall = layout.walls[n];
    const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
    const Eigen::Vector2d inward(-along.y(), along.x());
    const double turned = std::abs(along.dot(print.x_axis));
    if (turned < kAlong && std::sqrt(1 - std::min(1.0, turned * turned)) < kAlong) continue;
    const double at_m = along.dot(print.middle_m - wall.from_m);
    if (at_m < 0 || at_m > wall.length_m()) continue;
    double before_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& corner : print.corners_m)
      before_m = std::min(before_m, inward.dot(corner - wall.from_m));
    if (before_m < kIntoWall_m || std::abs(before_m) >= nearest_m) continue;
    nearest_m = std::abs(before_m);
    nearest = static_cast<int>(n);
  }
  return nearest;
}

std::optional<std::size_t> ThingBelow(const std::vector<ThingBox>& things,
                                      const std::vector<Footprint>& prints,
                                      std::size_t number) {
  std::optional<std::size_t> best;
  double best_m = kTouching_m;
  for (std::size_t n = 0; n < things.size(); ++n) {
    const double gap_m = std::abs(prints[number].bottom_m - prints[n].top_m);
    if (n == number || gap_m >= best_m || !Holds(things[n], prints[number].middle_m)) continue;
    best_m = gap_m;
    best = n;
  }
  return best;
}

}  // namespace

std::vector<Relations> RelationsOf(const Layout& layout, const std::vector<ThingBox>& things) {
  std::vector<Footprint> prints;
  for (const ThingBox& thing : things) prints.push_back(FootprintOf(thing));
  std::vector<Relations> all;
  for (std::size_t n = 0; n < things.size(); ++n) {
    Relations relations;
    relations.room = RoomOf(layout, prints[n]);
    relations.against_wall = WallAt(layout, prints[n]);
    relations.on = ThingBelow(things, prints, n);
    const double floor_m =
        relations.room ? layout.rooms[static_cast<std::size_t>(*relations.room)].floor_m : 0;
    if (std::abs(prints[n].bottom_m - floor_m) < kTouching_m) {
      relations.support = Support::kFloor;
      relations.on.reset();
    } else if (relations.on) {
      relations.support = Support::kThing;
    } else if (relations.against_wall && prints[n].bottom_m > floor_m + kHanging_m) {
      relations.support = Support::kWall;
    }
    all.push_back(relations);
  }
  return all;
}

}  // namespace deepslam::layout
