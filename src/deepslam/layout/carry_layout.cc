#include "deepslam/layout/carry_layout.h"

#include <algorithm>
#include <cmath>

#include "deepslam/scene/wall_geometry.h"

namespace deepslam::layout {
namespace {

// How far a camera's word reaches: rooms are seen from a few metres.
constexpr double kCameraReach_m = 2.0;
constexpr double kFarthest =
    4.0;  // of it; all cameras count a little, so that something always does

class Carrier {
 public:
  explicit Carrier(const std::vector<MovedCamera>& cameras) : cameras_(cameras) {
    for (const MovedCamera& camera : cameras)
      world_from_level_.push_back(camera.world_from_camera * camera.level_from_camera.Inverse());
  }

  [[nodiscard]] Eigen::Vector3d Moved(const Eigen::Vector3d& p_level) const {
    double whole = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t n = 0; n < cameras_.size(); ++n) {
      const double off =
          (cameras_[n].level_from_camera.translation_m - p_level).norm() / kCameraReach_m;
      const double weight = std::exp(-std::min(off, kFarthest) * std::min(off, kFarthest) / 2);
      whole += weight;
      sum += weight * (world_from_level_[n] * p_level);
    }
    return sum / whole;
  }
  // Along the ground, at eye level; and up, at a place.
  [[nodiscard]] Eigen::Vector2d OnGround(const Eigen::Vector2d& p) const {
    constexpr double kEyes_m = 1.5;  // about where cameras are carried
    return Moved({p.x(), p.y(), kEyes_m}).head<2>();
  }
  [[nodiscard]] double Height(const Eigen::Vector2d& p, double height_m) const {
    return Moved({p.x(), p.y(), height_m}).z();
  }

 private:
  const std::vector<MovedCamera>& cameras_;
  std::vector<Pose3> world_from_level_;
};

Eigen::Vector2d MiddleOf(const std::vector<Eigen::Vector2d>& polygon_m) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : polygon_m) sum += p;
  return sum / static_cast<double>(polygon_m.size());
}

// Openings stay in their walls: at the same share of its length.
Eigen::Vector2d OnMovedWall(const LayoutWall& before,
                            const LayoutWall& moved,
                            const Eigen::Vector2d& p) {
  const double length_m = before.length_m();
  if (!(length_m > 0)) return moved.from_m;
  const Eigen::Vector2d along = (before.to_m - before.from_m) / length_m;
  const double share = along.dot(p - before.from_m) / length_m;
  return moved.from_m + share * (moved.to_m - moved.from_m);
}

}  // namespace

Layout CarryLayout(Layout layout, const std::vector<MovedCamera>& cameras) {
  layout.level_from_tracking = Pose3();
  if (cameras.empty()) return layout;
  const Carrier carrier(cameras);
  for (LayoutRoom& room : layout.rooms) {
    const Eigen::Vector2d middle = MiddleOf(room.polygon_m);
    if (HasCeiling(room)) room.ceiling_m = carrier.Height(middle, room.ceiling_m);
    room.floor_m = carrier.Height(middle, room.floor_m);
    for (Eigen::Vector2d& corner : room.polygon_m) corner = carrier.OnGround(corner);
  }
  const std::vector<LayoutWall> as_read = layout.walls;
  for (LayoutWall& wall : layout.walls) {
    const Eigen::Vector2d middle = 0.5 * (wall.from_m + wall.to_m);
    wall.bottom_m = carrier.Height(middle, wall.bottom_m);
    wall.top_m = carrier.Height(middle, wall.top_m);
    wall.from_m = carrier.OnGround(wall.from_m);
    wall.to_m = carrier.OnGround(wall.to_m);
  }
  for (LayoutOpening& opening : layout.openings) {
    const Eigen::Vector2d middle = 0.5 * (opening.from_m + opening.to_m);
    opening.bottom_m = carrier.Height(middle, opening.bottom_m);
    opening.top_m = carrier.Height(middle, opening.top_m);
    const auto wall = static_cast<std::size_t>(opening.wall);
    opening.from_m = OnMovedWall(as_read[wall], layout.walls[wall], opening.from_m);
    opening.to_m = OnMovedWall(as_read[wall], layout.walls[wall], opening.to_m);
  }
  for (SlantedPlane& slanted : layout.slanted) {
    const Eigen::Vector3d centre = carrier.Moved(slanted.centre_m);
    const Eigen::Vector3d ahead = carrier.Moved(slanted.centre_m + slanted.plane.normal);
    slanted.centre_m = centre;
    slanted.plane.normal = (ahead - centre).normalized();
    slanted.plane.d_m = -slanted.plane.normal.dot(centre);
  }
  return layout;
}

}  // namespace deepslam::layout
