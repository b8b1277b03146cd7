#include "deepslam/geometry/upright.h"

#include <cmath>

namespace deepslam {
namespace {

constexpr double kLeastInPicture = 0.26;  // within 15 deg of the vertical there is no upper edge

}  // namespace

Eigen::Vector3d Turned(const Eigen::Vector3d& of_camera, QuarterTurn turn) {
  const Eigen::Vector3d& p = of_camera;
  switch (turn) {
    case QuarterTurn::kClockwise:
      return {-p.y(), p.x(), p.z()};
    case QuarterTurn::kAnticlockwise:
      return {p.y(), -p.x(), p.z()};
    case QuarterTurn::kHalf:
      return {-p.x(), -p.y(), p.z()};
    case QuarterTurn::kNone:
      break;
  }
  return p;
}

Plane Turned(const Plane& plane_camera, QuarterTurn turn) {
  return {Turned(plane_camera.normal, turn), plane_camera.d_m};
}

PinholeCamera Turned(const PinholeCamera& camera, QuarterTurn turn) {
  const double from_right = camera.width - 1 - camera.cx;
  const double from_below = camera.height - 1 - camera.cy;
  switch (turn) {
    case QuarterTurn::kClockwise:
      return {camera.height, camera.width, camera.fy, camera.fx, from_below, camera.cx};
    case QuarterTurn::kAnticlockwise:
      return {camera.height, camera.width, camera.fy, camera.fx, camera.cy, from_right};
    case QuarterTurn::kHalf:
      return {camera.width, camera.height, camera.fx, camera.fy, from_right, from_below};
    case QuarterTurn::kNone:
      break;
  }
  return camera;
}

Box2 Turned(const Box2& box_px, int width, int height, QuarterTurn turn) {
  const double last_u = width - 1;
  const double last_v = height - 1;
  const Box2& b = box_px;
  switch (turn) {
    case QuarterTurn::kClockwise:
      return {last_v - b.v_max, b.u_min, last_v - b.v_min, b.u_max};
    case QuarterTurn::kAnticlockwise:
      return {b.v_min, last_u - b.u_max, b.v_max, last_u - b.u_min};
    case QuarterTurn::kHalf:
      return {last_u - b.u_max, last_v - b.v_max, last_u - b.u_min, last_v - b.v_min};
    case QuarterTurn::kNone:
      break;
  }
  return b;
}

std::optional<QuarterTurn> UprightTurn(const Eigen::Vector3d& up_camera) {
  const double right = up_camera.x();
  const double down = up_camera.y();
  if (std::hypot(right, down) < kLeastInPicture * up_camera.norm()) return std::nullopt;
  if (std::abs(down) >= std::abs(right)) return down <= 0 ? QuarterTurn::kNone : QuarterTurn::kHalf;
  return right < 0 ? QuarterTurn::kClockwise : QuarterTurn::kAnticlockwise;
}

}  // namespace deepslam
