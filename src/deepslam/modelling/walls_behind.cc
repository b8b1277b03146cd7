#include "deepslam/modelling/walls_behind.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace deepslam::modelling {
namespace {

// How well walls are known: layouts place them within 1 to 3 cm of the measured surface.
constexpr double kSlack_m = 0.03;
// Of the box's length along the wall, which lies before the wall and not beside its end.
constexpr double kMinOverlap = 0.5;

struct Interval {
  double low = 0;
  double high = 0;
};

template <typename Project>
Interval RangeOf(const std::vector<Eigen::Vector3d>& points, const Project& project) {
  Interval range{project(points.front()), project(points.front())};
  for (const Eigen::Vector3d& p : points) {
    range.low = std::min(range.low, project(p));
    range.high = std::max(range.high, project(p));
  }
  return range;
}

std::vector<Eigen::Vector3d> CornersIn(const Similarity3& level_from_object,
                                       const shape::ShapeModel& model) {
  const Eigen::AlignedBox3d box(model.box_min().cast<double>(), model.box_max().cast<double>());
  std::vector<Eigen::Vector3d> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back(level_from_object *
                      box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k)));
  return corners;
}

// The room is to the left of the way from `from_m` to `to_m`.
Plane FaceOf(const LayoutWall& wall) {
  const Eigen::Vector2d along = (wall.to_m - wall.from_m) / wall.length_m();
  const Eigen::Vector2d normal(-along.y(), along.x());
  return {{normal.x(), normal.y(), 0}, -normal.dot(wall.from_m)};
}

bool IsCrossed(const LayoutWall& wall,
               const Plane& face,
               const std::vector<Eigen::Vector3d>& corners) {
  const Interval before = RangeOf(corners, [&](const auto& p) { return face.SignedDistance(p); });
  if (before.low >= -kSlack_m || before.high <= 0) return false;
  const Eigen::Vector2d direction = (wall.to_m - wall.from_m) / wall.length_m();
  const Interval along = RangeOf(
      corners, [&](const auto& p) { return direction.dot(p.template head<2>() - wall.from_m); });
  const double overlap_m = std::min(along.high, wall.length_m()) - std::max(along.low, 0.0);
  const Interval height = RangeOf(corners, [](const auto& p) { return p.z(); });
  const double middle_m = 0.5 * (height.low + height.high);
  return overlap_m >= kMinOverlap * (along.high - along.low) && wall.bottom_m <= middle_m &&
         middle_m <= wall.top_m;
}

bool IsBeforeAll(const Plane& face,
                 const Pose3& level_from_world,
                 std::span<const ObjectView> views) {
  return std::ranges::all_of(views, [&](const ObjectView& view) {
    return face.SignedDistance(level_from_world * view.world_from_camera.translation_m) > 0;
  });
}

}  // namespace

std::vector<Plane> WallsBehind(const Layout& layout,
                               const shape::ShapeModel& model,
                               const Similarity3& world_from_object,
                               std::span<const ObjectView> views) {
  std::vector<Plane> walls;
  if (model.empty()) return walls;
  const Similarity3 level_from_object = layout.level_from_tracking * world_from_object;
  const Pose3 object_from_level = level_from_object.RigidPart().Inverse();
  const std::vector<Eigen::Vector3d> corners = CornersIn(level_from_object, model);
  for (const LayoutWall& wall : layout.walls) {
    if (!(wall.length_m() > 0)) continue;
    Plane face = FaceOf(wall);
    if (!IsCrossed(wall, face, corners) || !IsBeforeAll(face, layout.level_from_tracking, views))
      continue;
    face.d_m += kSlack_m;
    Plane in_object = Transformed(object_from_level, face);
    in_object.d_m /= level_from_object.scale;
    walls.push_back(in_object);
  }
  return walls;
}

}  // namespace deepslam::modelling
