#include "deepslam/propose/level_box.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

#include "deepslam/core/angles.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam::propose {
namespace {

// Share of cells left out at either end of an extent: stray cells of segments that leak.
constexpr double kOutlierShare = 0.01;
// How much of the evidence for its own direction (Closeness over footprint) that of the wall has to
// have. Plants and what lies along walls have 0.81 to 1.05 over eleven homes and an apartment,
// chairs that real rooms hold turned 0.76 at most.
constexpr double kAlongWall = 0.8;

// Directions that differ by less are the same but for what measuring adds.
constexpr double kAlikeRad = 5 * kRadPerDeg;

double FootprintOf(const LevelBox& box) { return box.size_m.x() * box.size_m.y(); }

// How close the points are to the box's upright sides: the mean of 1 / distance, a cell's side at
// least.
double Closeness(std::span<const Eigen::Vector3f> points, const LevelBox& box) {
  const auto c = static_cast<float>(std::cos(box.yaw_rad));
  const auto s = static_cast<float>(std::sin(box.yaw_rad));
  const Eigen::Vector2f center = box.center_m.cast<float>();
  const Eigen::Vector2f half = 0.5F * box.size_m.head<2>().cast<float>();
  double sum = 0;
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector2f d = p.head<2>() - center;
    const float to_x = std::abs(std::abs(c * d.x() + s * d.y()) - half.x());
    const float to_y = std::abs(std::abs(c * d.y() - s * d.x()) - half.y());
    sum += 1.0 / std::max(kCloudCell_m, std::min(to_x, to_y));
  }
  return sum / static_cast<double>(points.size());
}

double EvidenceFor(const LevelBox& box, std::span<const Eigen::Vector3f> points) {
  return Closeness(points, box) / FootprintOf(box);
}

// The box between the steps of MeasureBox.
LevelBox Sharpened(std::span<const Eigen::Vector3f> points, const LevelBox& box) {
  constexpr double kStepRad = 0.5 * kRadPerDeg;  // a quarter of one of MeasureBox
  constexpr int kNumSteps = 3;                   // to either side: less than one of MeasureBox
  std::vector<LevelBox> boxes = {box};
  for (int n = -kNumSteps; n <= kNumSteps; ++n) {
    if (n != 0) boxes.push_back(MeasureBoxAt(points, box.yaw_rad + n * kStepRad));
  }
  return *std::ranges::max_element(
      boxes, {}, [&](const LevelBox& turned) { return EvidenceFor(turned, points); });
}

// The direction of the wall nearest to the place, as a yaw of the level frame; none without walls.
std::optional<double> YawAlongWall(const Layout& layout,
                                   const Pose3& level_from_world,
                                   const Eigen::Vector2d& place_level) {
  if (layout.walls.empty()) return std::nullopt;
  const Pose3 layout_from_level = layout.level_from_tracking * level_from_world.Inverse();
  const Eigen::Vector2d place =
      (layout_from_level * Eigen::Vector3d(place_level.x(), place_level.y(), 0)).head<2>();
  const LayoutWall& wall = *std::ranges::min_element(
      layout.walls, {}, [&](const LayoutWall& w) { return DistanceTo(w, place); });
  const Eigen::Vector2d along = AlongOf(wall);
  const Eigen::Vector3d along_level =
      layout_from_level.rotation.inverse() * Eigen::Vector3d(along.x(), along.y(), 0);
  return std::atan2(along_level.y(), along_level.x());
}

}  // namespace

LevelBox MeasureBoxAt(std::span<const Eigen::Vector3f> points, double yaw_rad) {
  LevelBox box;
  box.yaw_rad = yaw_rad;
  if (points.empty()) return box;
  const Eigen::Vector2f x_axis(static_cast<float>(std::cos(yaw_rad)),
                               static_cast<float>(std::sin(yaw_rad)));
  const Eigen::Vector2f y_axis(-x_axis.y(), x_axis.x());
  Eigen::Vector2d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    values.reserve(points.size());
    for (const Eigen::Vector3f& p : points) {
      values.push_back(axis == 0   ? x_axis.dot(p.head<2>())
                       : axis == 1 ? y_axis.dot(p.head<2>())
                                   : p.z());
    }
    const double high = Quantile(values, 1.0 - kOutlierShare);
    const double low = axis == 2 ? 0.0 : Quantile(values, kOutlierShare);
    box.size_m[axis] = std::max(high - low, static_cast<double>(kCloudCell_m));
    if (axis < 2) middle[axis] = 0.5 * (low + high);
  }
  box.center_m = (middle.x() * x_axis.cast<double>() + middle.y() * y_axis.cast<double>());
  return box;
}

LevelBox MeasureBox(std::span<const Eigen::Vector3f> points) {
  constexpr int kTurnSteps = 45;  // of 2 degrees: after a quarter turn boxes repeat
  // The thickness of measured faces, 3 cm, makes a box of 0.5 m along two of them 5 % larger than
  // the one along the diagonal, and what sticks out of one, a handle, as much again.
  constexpr double kNearlySmallest = 1.2;
  std::vector<LevelBox> boxes(kTurnSteps);
  ParallelFor(boxes.size(), [&](std::size_t n) {
    boxes[n] = MeasureBoxAt(points, 0.5 * std::numbers::pi * static_cast<double>(n) / kTurnSteps);
  });
  const auto smallest = std::ranges::min_element(boxes, {}, FootprintOf);
  if (points.empty()) return *smallest;
  const double most_m2 = kNearlySmallest * FootprintOf(*smallest);
  LevelBox best = *smallest;
  double closest = Closeness(points, best);
  for (const LevelBox& box : boxes) {
    if (FootprintOf(box) > most_m2) continue;
    const double closeness = Closeness(points, box);
    if (closeness <= closest) continue;
    best = box;
    closest = closeness;
  }
  return best;
}

LevelBox MeasureBox(const ObjectObservations& object, const LevelCloud& cloud) {
  const LevelBox box = Sharpened(cloud.points, MeasureBox(cloud.points));
  if (object.layout == nullptr || cloud.points.empty()) return box;
  const std::optional<double> yaw_rad =
      YawAlongWall(*object.layout, cloud.level_from_world, box.center_m);
  if (!yaw_rad) return box;
  const double off_rad = std::remainder(box.yaw_rad - *yaw_rad, 0.5 * std::numbers::pi);
  if (std::abs(off_rad) < kAlikeRad) return box;
  const LevelBox along_wall = MeasureBoxAt(cloud.points, *yaw_rad);
  const double asked = kAlongWall * EvidenceFor(box, cloud.points);
  return EvidenceFor(along_wall, cloud.points) >= asked ? along_wall : box;
}

}  // namespace deepslam::propose
