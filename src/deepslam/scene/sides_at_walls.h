// Which sides of an upright box stand at walls, and what that says of its front.
#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/geometry/pose.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/layout.h"

namespace deepslam {

// By the side's outward normal in the box's frame: +x, +y, -x, -y. Side q is the front of the box
// once it is turned by -q quarters.
using SidesAtWalls = std::array<bool, 4>;

// Of the box of these sides round the origin of a frame whose z is up in the layout's level world.
// A side stands at a wall's face that it is parallel to within 20 deg and near to within 15 cm, or
// reaches through, over half of its length, with the opposite side before the face.
[[nodiscard]] SidesAtWalls FindSidesAtWalls(const Layout& layout,
                                            const Pose3& level_from_box,
                                            const Eigen::Vector3d& size_m);

// How unlikely the side's being the front is, by the walls: furniture stands with its back to a
// wall. 0: its back stands at one, or no side does; 0.5: others do and its back does not; 1: it
// stands at one itself.
[[nodiscard]] double FrontBlocked(const SidesAtWalls& at_walls, int side);

// The same of the front (+x) of a model of this box in its own frame, where it stands.
[[nodiscard]] double FrontBlocked(const Layout& layout,
                                  const Similarity3& tracking_from_object,
                                  const Eigen::AlignedBox3f& box_object);

// How unlikely it is that a box of these sides round the origin of its frame, its front at +x,
// stands there: as FrontBlocked says, or 1 where a side of it reaches 30 cm and more through a
// wall.
[[nodiscard]] double WallConflict(const Layout& layout,
                                  const Pose3& level_from_box,
                                  const Eigen::Vector3d& size_m);
[[nodiscard]] double WallConflict(const Layout& layout,
                                  const Similarity3& tracking_from_object,
                                  const Eigen::AlignedBox3f& box_object);

}  // namespace deepslam
