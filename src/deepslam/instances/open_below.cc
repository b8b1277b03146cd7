#include "deepslam/instances/open_below.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <Eigen/Core>

#include "deepslam/geometry/level_rectangle.h"
#include "deepslam/geometry/top_layer.h"
#include "deepslam/instances/support_height.h"

namespace deepslam::instances {
namespace {

constexpr double kRightAngle_rad = 0.5 * std::numbers::pi;  // from a box's x axis to its y axis
// Shorter ones may be nightstands on legs.
constexpr double kMinLongSideM = 0.6;
constexpr float kUprightNormal = 0.5F;  // z of a normal that faces aside, at most
// Thickness of a top's layer: more than two voxels, so that a level face lies in it.
constexpr double kLayerM = 0.08;
// Of the box seen from above. Of tables with things on them less is seen than of bare ones (1).
constexpr double kMinTopShare = 0.4;
// Of the floor in the box, this far from its sides. Cabinets on legs let some be seen.
constexpr double kMinFloorShare = 0.5;
constexpr double kInsetM = 0.06;  // two voxels: the sides scatter by as much
constexpr double kFloorM = 0.12;  // what is fused of the floor scatters by as much
// Of the long side below the top: aprons and legs cover up to a third, fronts of cabinets, if half
// hidden, more.
constexpr double kMaxCoveredShare = 0.35;

// Of the thing's long side below a height that some upright surface of it covers, seen from before.
double CoveredShare(std::span<const int> own,
                    const UprightBox& box,
                    double top_m,
                    const SurfaceElements& elements) {
  const double height_m = top_m - kLayerM - box.bottom_m;
  if (height_m <= 0) return 0;  // of the top alone was seen
  const double yaw_rad = box.length_m > box.width_m ? box.yaw_rad : box.yaw_rad + kRightAngle_rad;
  const Eigen::Vector2d along(std::cos(yaw_rad), std::sin(yaw_rad));
  std::set<std::pair<int, int>> covered;  // voxels along the side and upwards
  for (const int i : own) {
    const auto n = static_cast<std::size_t>(i);
    const Eigen::Vector3d p = elements.points()[n].cast<double>();
    if (std::abs(elements.normals()[n].z()) >= kUprightNormal || p.z() >= top_m - kLayerM) continue;
    covered.emplace(static_cast<int>(std::floor(along.dot(p.head<2>()) / elements.voxel_m())),
                    static_cast<int>(std::floor(p.z() / elements.voxel_m())));
  }
  return static_cast<double>(covered.size()) * elements.voxel_m() * elements.voxel_m() /
         (box.long_side_m() * height_m);
}

// Of the floor within the box.
double FloorShare(const UprightBox& box,
                  const SurfaceElements& elements,
                  const Superpoints& superpoints) {
  const LevelRectangle inner = OutlineOf(box, -kInsetM);
  if (inner.length_m <= 0 || inner.width_m <= 0) return 0;
  std::size_t num_floor = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Eigen::Vector3d p = elements.points()[i].cast<double>();
    if (superpoints.of_element[i] >= 0 || std::abs(p.z()) > kFloorM) continue;
    if (inner.Contains(p.head<2>())) ++num_floor;
  }
  return static_cast<double>(num_floor) * elements.voxel_m() * elements.voxel_m() / inner.area_m2();
}

}  // namespace

std::optional<double> LevelFaceHeight(std::span<const int> own,
                                      const UprightBox& box_level,
                                      const SurfaceElements& elements) {
  if (box_level.long_side_m() < kMinLongSideM) return std::nullopt;
  const std::vector<double> heights_m = HeightsFacingUp(own, elements);
  const std::span<const double> top_m = FullestLayer(heights_m, kLayerM);
  if (top_m.empty()) return std::nullopt;
  const double area_m2 =
      static_cast<double>(top_m.size()) * elements.voxel_m() * elements.voxel_m();
  if (area_m2 < kMinTopShare * box_level.length_m * box_level.width_m) return std::nullopt;
  return top_m.back();
}

bool IsTopOnLegs(std::span<const int> own,
                 const UprightBox& box_level,
                 const SurfaceElements& elements) {
  const std::optional<double> top_m = LevelFaceHeight(own, box_level, elements);
  return top_m && CoveredShare(own, box_level, *top_m, elements) <= kMaxCoveredShare;
}

bool IsFloorSeenIn(const UprightBox& box_level,
                   const SurfaceElements& elements,
                   const Superpoints& superpoints) {
  return FloorShare(box_level, elements, superpoints) >= kMinFloorShare;
}

}  // namespace deepslam::instances
