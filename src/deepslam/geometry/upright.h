// Cameras turned by quarters about their optical axis, and which turn sets a picture upright.
//
// The turned camera sees the turned picture (core/quarter_turn.h), from the same place along the
// same axis.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "deepslam/core/quarter_turn.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"

namespace deepslam {

// A direction or point of the camera's frame in the turned one's.
[[nodiscard]] Eigen::Vector3d Turned(const Eigen::Vector3d& of_camera, QuarterTurn turn);
[[nodiscard]] Plane Turned(const Plane& plane_camera, QuarterTurn turn);
[[nodiscard]] PinholeCamera Turned(const PinholeCamera& camera, QuarterTurn turn);
// A box of the picture of this width and height (px) in the turned picture.
[[nodiscard]] Box2 Turned(const Box2& box_px, int width, int height, QuarterTurn turn);

// The turn that brings what is above to the upper edge, within 45 deg. Nothing where the camera
// looks so steeply up or down that the picture has hardly an upper edge.
[[nodiscard]] std::optional<QuarterTurn> UprightTurn(const Eigen::Vector3d& up_camera);

}  // namespace deepslam
