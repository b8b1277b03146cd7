// Where things are in a layout: in which room, on what, against which wall.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "deepslam/geometry/pose.h"
#include "deepslam/scene/layout.h"

namespace deepslam::layout {

// A thing's box: axes of the object's frame, its origin in the middle. World of the layout.
struct ThingBox {
  Pose3 world_from_object;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
};

enum class Support { kUnknown, kFloor, kThing, kWall };

struct Relations {
  std::optional<int> room;  // whose polygon holds its middle
  Support support = Support::kUnknown;
  std::optional<std::size_t> on;    // the thing it stands on
  std::optional<int> against_wall;  // the nearest wall that a side of it stands at
};

// One per thing.
[[nodiscard]] std::vector<Relations> RelationsOf(const Layout& layout,
                                                 const std::vector<ThingBox>& things);

}  // namespace deepslam::layout
