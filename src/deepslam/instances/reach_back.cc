#include "deepslam/instances/reach_back.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "deepslam/core/angles.h"
#include "deepslam/instances/wall_axes.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::instances {
namespace {

// Between a front and the wall, of all furniture for homes: bookshelves are 0.2 m deep, wardrobes
// and counters 0.6, refrigerators 0.8.
constexpr double kLeastDepthM = 0.2;
constexpr double kMostDepthM = 0.85;  // and what stands a little before its wall
// Of the box's side to the wall: boxes are told to 3 degrees, and a thing stands a little askew.
const double kAlongWall = std::cos(12 * kRadPerDeg);
constexpr float kFacing = 0.8F;      // of a front's normal to the wall's: within 37 degrees
constexpr double kWallAboveM = 0.1;  // of the wall above the thing: else the two may be one
constexpr double kScatterM = 0.08;   // surfaces of the box and the wall scatter by as much
// Of the front, seen between the two: what stands out of the room's corners or lies on top.
constexpr double kMaxSeenShare = 0.05;

// A box by a wall.
struct ByWall {
  WallAxes axes;
  double begin_m = 0;  // of the box, along the wall from its beginning
  double end_m = 0;
  double front_m = 0;  // before the wall
  double back_m = 0;
};

std::optional<ByWall> PlaceBy(const LayoutWall& wall, const UprightBox& box) {
  const std::optional<WallAxes> axes = AxesOf(wall);
  if (!axes) return std::nullopt;
  if (std::abs(box.long_axis().dot(axes->along)) < kAlongWall) return std::nullopt;
  const OnWall middle = axes->Place(box.centre_m);
  const ByWall place{*axes,
                     middle.along_m - 0.5 * box.long_side_m(),
                     middle.along_m + 0.5 * box.long_side_m(),
                     middle.before_m + 0.5 * box.short_side_m(),
                     middle.before_m - 0.5 * box.short_side_m()};
  if (middle.along_m < 0 || middle.along_m > wall.length_m() || place.back_m < kScatterM ||
      place.front_m < kLeastDepthM || place.front_m > kMostDepthM)
    return std::nullopt;
  return place;
}

// Surface between the box and the wall, and of the wall behind it, as a share of the front. Below
// what hangs the wall is seen; what stands has the floor there.
double SeenShare(const ByWall& place, const UprightBox& box, const SurfaceElements& elements) {
  const double lowest_m = box.bottom_m + (box.bottom_m > kMaxHiddenBase_m ? kScatterM : -kScatterM);
  std::size_t num_seen = 0;
  for (const Eigen::Vector3f& point : elements.points()) {
    const Eigen::Vector3d p = point.cast<double>();
    if (p.z() > box.top_m - kScatterM || p.z() < lowest_m) continue;
    const OnWall at = place.axes.Place(p.head<2>());
    if (at.along_m > place.begin_m + kScatterM && at.along_m < place.end_m - kScatterM &&
        at.before_m > -kScatterM && at.before_m < place.back_m - kScatterM)
      ++num_seen;
  }
  const double voxel_m2 = elements.voxel_m() * elements.voxel_m();
  return static_cast<double>(num_seen) * voxel_m2 / (box.long_side_m() * box.height_m());
}

UprightBox WithBackAt(const ByWall& place, UprightBox box) {
  (box.length_m > box.width_m ? box.width_m : box.length_m) = place.front_m;
  box.centre_m -= 0.5 * place.back_m * place.axes.inward;
  return box;
}

}  // namespace

std::optional<UprightBox> ReachBack(const UprightBox& box,
                                    const Eigen::Vector3f& facing,
                                    std::span<const LayoutWall> walls,
                                    const SurfaceElements& elements) {
  if (box.height_m() <= 0 || box.long_side_m() <= 0) return std::nullopt;
  const Eigen::Vector2f aside = facing.head<2>();
  for (const LayoutWall& wall : walls) {
    if (wall.top_m < box.top_m + kWallAboveM) continue;
    const std::optional<ByWall> place = PlaceBy(wall, box);
    if (!place || aside.dot(place->axes.inward.cast<float>()) < kFacing * facing.norm()) continue;
    if (SeenShare(*place, box, elements) <= kMaxSeenShare) return WithBackAt(*place, box);
  }
  return std::nullopt;
}

}  // namespace deepslam::instances
