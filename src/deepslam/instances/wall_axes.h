// Places as a wall's face has them: along it, and before it in the room.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "deepslam/scene/layout.h"

namespace deepslam::instances {

struct OnWall {
  double along_m = 0;   // from its beginning
  double before_m = 0;  // to the room's side
};

struct WallAxes {
  Eigen::Vector2d from_m;
  Eigen::Vector2d along;
  Eigen::Vector2d inward;  // to the room, which lies to the left

  [[nodiscard]] OnWall Place(const Eigen::Vector2d& p) const {
    return {along.dot(p - from_m), inward.dot(p - from_m)};
  }
};

// Nothing of a wall without length.
inline std::optional<WallAxes> AxesOf(const LayoutWall& wall) {
  const double length_m = wall.length_m();
  if (length_m <= 0) return std::nullopt;
  const Eigen::Vector2d along = (wall.to_m - wall.from_m) / length_m;
  return WallAxes{wall.from_m, along, {-along.y(), along.x()}};
}

}  // namespace deepslam::instances
