// How the walls of a layout stand to each other, and what rooms have.
#pragma once

#include <optional>
#include <utility>

#include <Eigen/Core>

#include "deepslam/scene/layout.h"

namespace deepslam {

// Faces of one wall lie no further apart than this.
inline constexpr double kThickestWall_m = 0.5;

// Whether the room's ceiling was seen (ceiling_m is 0 where it was not, and floors may lie below
// 0).
[[nodiscard]] inline bool HasCeiling(const LayoutRoom& room) {
  return room.ceiling_m != 0 && room.ceiling_m > room.floor_m;
}

// Unit vector from a wall's beginning to its end; x for a wall without length. Its room lies left.
[[nodiscard]] Eigen::Vector2d AlongOf(const LayoutWall& wall);

// How far a point lies to the left of the wall's line: before its face.
[[nodiscard]] double DistanceBefore(const LayoutWall& wall, const Eigen::Vector2d& p_m);

// How far a point is from the wall, its ends included.
[[nodiscard]] double DistanceTo(const LayoutWall& wall, const Eigen::Vector2d& p_m);

// How thick the wall is: to the nearest face behind it that faces the other way beside it; nothing
// where there is none within kThickestWall_m.
[[nodiscard]] std::optional<double> ThicknessOf(const Layout& layout, const LayoutWall& wall);

// Whether the wall meets another at its end (or its beginning) in a hollow corner of the room. What
// stands for the walls has to be lengthened there by its thickness, or a notch stays.
[[nodiscard]] bool MeetsInHollowCorner(const Layout& layout, const LayoutWall& wall, bool at_end);

// Where an opening begins and ends along a wall, from the wall's beginning; first < second.
[[nodiscard]] std::pair<double, double> SpanOf(const LayoutOpening& opening,
                                               const LayoutWall& wall);

// Whether an opening of another wall goes through this one: both are faces of one wall.
[[nodiscard]] bool GoesThrough(const Layout& layout,
                               const LayoutOpening& opening,
                               const LayoutWall& wall);

}  // namespace deepslam
