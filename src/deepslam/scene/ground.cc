#include "deepslam/scene/ground.h"

#include <algorithm>
#include <cmath>

namespace deepslam {

const GroundApart* ApartAt(const Ground& ground, FrameIdx frame) {
  const auto at =
      std::find_if(ground.apart.begin(), ground.apart.end(), [&](const GroundApart& apart) {
        return apart.first <= frame && frame < apart.end;
      });
  return at == ground.apart.end() ? nullptr : &*at;
}

std::optional<Plane> GroundInCamera(const Ground& ground,
                                    FrameIdx frame,
                                    const Pose3& world_from_camera) {
  const auto seen = std::lower_bound(
      ground.observations.begin(),
      ground.observations.end(),
      frame,
      [](const GroundObservation& o, FrameIdx wanted) { return o.keyframe < wanted; });
  if (seen != ground.observations.end() && seen->keyframe == frame) return seen->plane_camera;
  const GroundApart* apart = ApartAt(ground, frame);
  const std::optional<Plane>& plane_world = apart ? apart->plane_world : ground.plane_world;
  if (!plane_world) return std::nullopt;
  return Transformed(world_from_camera.Inverse(), *plane_world);
}

Eigen::Matrix<double, 3, 2> GroundTangentBasis(const Eigen::Vector3d& normal) {
  // The coordinate axis least aligned with the normal keeps the cross product well away from zero.
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Eigen::Vector3d b1 = normal.cross(Eigen::Vector3d::Unit(axis)).normalized();
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = b1;
  basis.col(1) = normal.cross(b1);
  return basis;
}

}  // namespace deepslam
