#include "deepslam/modelling/measured_limits.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "deepslam/geometry/top_layer.h"
#include "deepslam/propose/level_box.h"
#include "deepslam/propose/level_cloud.h"

namespace deepslam::modelling {
namespace {

// Of the points, where that is a layer of one cell and holds a part that nothing but a level face
// has: of an upright face of 0.7 m a thirtieth.
constexpr double kLevelShare = 0.15;

std::optional<double> HeightOfLevelFace(const std::vector<Eigen::Vector3f>& points) {
  std::vector<double> heights_m;
  for (const Eigen::Vector3f& p : points) heights_m.push_back(p.z());
  std::ranges::sort(heights_m);
  const std::span<const double> top_m = TopLayer(heights_m, propose::kCloudCell_m);
  if (static_cast<double>(top_m.size()) < kLevelShare * static_cast<double>(heights_m.size()))
    return std::nullopt;
  return top_m[top_m.size() / 2];
}

std::vector<Plane> SidesOf(const propose::LevelBox& box) {
  const Eigen::Vector3d x_axis(std::cos(box.yaw_rad), std::sin(box.yaw_rad), 0);
  const Eigen::Vector3d y_axis(-x_axis.y(), x_axis.x(), 0);
  const Eigen::Vector3d center_m(box.center_m.x(), box.center_m.y(), 0);
  std::vector<Plane> sides;
  for (const int axis : {0, 1}) {
    const Eigen::Vector3d along = axis == 0 ? x_axis : y_axis;
    const double half_m = 0.5 * box.size_m[axis];
    sides.push_back({-along, along.dot(center_m) + half_m});
    sides.push_back({along, -along.dot(center_m) + half_m});
  }
  return sides;
}

Plane TopAt(double height_m) { return {-Eigen::Vector3d::UnitZ(), height_m}; }

Plane InModel(const Similarity3& level_from_object, const Plane& plane_level) {
  Plane plane = Transformed(level_from_object.RigidPart().Inverse(), plane_level);
  plane.d_m /= level_from_object.scale;
  return plane;
}

}  // namespace

refine::Limits MeasuredLimits(const Similarity3& world_from_object,
                              std::span<const ObjectView> views,
                              bool has_support_plane) {
  refine::Limits limits;
  const propose::LevelCloud cloud = propose::AccumulateLevel(views);
  if (cloud.points.empty()) return limits;
  const Similarity3 level_from_object = cloud.level_from_world * world_from_object;
  const Eigen::Vector3d front_level = level_from_object.rotation * Eigen::Vector3d::UnitX();
  const propose::LevelBox box =
      propose::MeasureBoxAt(cloud.points, std::atan2(front_level.y(), front_level.x()));
  for (const Plane& side : SidesOf(box)) limits.sides.push_back(InModel(level_from_object, side));
  const std::optional<double> face_m =
      has_support_plane ? HeightOfLevelFace(cloud.points) : std::nullopt;
  if (face_m) {
    limits.top = InModel(level_from_object, TopAt(*face_m));
  } else {
    limits.sides.push_back(InModel(level_from_object, TopAt(box.size_m.z())));
  }
  return limits;
}

}  // namespace deepslam::modelling
