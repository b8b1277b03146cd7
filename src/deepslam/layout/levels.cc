#include "deepslam/layout/levels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "deepslam/core/order_statistics.h"

namespace deepslam::layout {
namespace {

constexpr double kLevelPlane = 0.98;     // least vertical part of a level's normal: 11 deg
constexpr double kSteepest = 0.98;       // what is slanted is 11 deg from lying
constexpr double kLeastSteep = 0.2;      // and 12 deg from standing
constexpr double kSlanted_m2 = 1.5;      // smaller slopes are of furniture
constexpr double kGround_m = 0.10;       // the ground, with carpets and noise
constexpr double kFlush_m = 0.04;        // what small planes of the ground are off it
constexpr double kSameLevel_m = 0.08;    // steps are twice as high
constexpr double kFloorBelow_m2 = 0.5;   // smaller planes off the ground are steps and furniture
constexpr double kCeiling_m2 = 0.5;      // smaller ones are undersides of lamps and lintels
constexpr double kHighestFloor_m = 2.0;  // above the ground
// How high a camera is carried, and how many of the fused frames were taken over a floor.
constexpr double kCarriedFrom_m = 0.9;
constexpr double kCarriedTo_m = 2.2;      // overhead, at the end of an arm
constexpr double kUnderFoot_m = 0.3;      // along the ground: cameras are held before the body
constexpr std::size_t kFewestFrames = 2;  // one may be a pose that is wrong

bool IsOver(const CoarseSurface& surface,
            const SurfacePlane& plane,
            const Eigen::Vector3f& viewpoint) {
  return std::any_of(plane.vertices.begin(), plane.vertices.end(), [&](std::uint32_t v) {
    return static_cast<double>((surface.mesh.vertices[v] - viewpoint).head<2>().norm()) <
           kUnderFoot_m;
  });
}

// Whether cameras were carried over the plane by somebody who stood on it. Beside a bed or a low
// table they are as high as anywhere; on a step they are higher by about the step.
bool WasWalkedOn(const CoarseSurface& surface, const SurfacePlane& plane) {
  const double height_m = plane.centre_m.z();
  std::vector<double> over_m;  // heights above the ground
  std::vector<double> elsewhere_m;
  for (const Eigen::Vector3f& viewpoint : surface.viewpoints) {
    const auto z_m = static_cast<double>(viewpoint.z());
    if (!IsOver(surface, plane, viewpoint)) {
      elsewhere_m.push_back(z_m);
    } else if (z_m - height_m > kCarriedFrom_m && z_m - height_m < kCarriedTo_m) {
      over_m.push_back(z_m);
    }
  }
  if (over_m.size() < kFewestFrames) return false;
  return elsewhere_m.empty() || Median(over_m) - Median(elsewhere_m) > 0.5 * height_m;
}

void AddLevel(LevelKind kind, const SurfacePlane& plane, std::vector<LayoutLevel>& levels) {
  for (LayoutLevel& level : levels) {
    if (level.kind != kind || std::abs(level.height_m - plane.centre_m.z()) > kSameLevel_m)
      continue;
    const double area_m2 = level.area_m2 + plane.area_m2;
    level.height_m += (plane.centre_m.z() - level.height_m) * plane.area_m2 / area_m2;
    level.area_m2 = area_m2;
    return;
  }
  levels.push_back({kind, plane.centre_m.z(), plane.area_m2});
}

bool IsFloor(const CoarseSurface& surface, const SurfacePlane& plane) {
  const double height_m = plane.centre_m.z();
  if (std::abs(height_m) < kFlush_m) return surface.has_ground;
  if (std::abs(height_m) < kGround_m) return surface.has_ground && plane.area_m2 > kFloorBelow_m2;
  if (height_m < 0) return plane.area_m2 > kFloorBelow_m2;
  return height_m < kHighestFloor_m && plane.area_m2 > kFloorBelow_m2 &&
         WasWalkedOn(surface, plane);
}

}  // namespace

std::vector<LayoutLevel> FindLevels(const CoarseSurface& surface,
                                    const std::vector<SurfacePlane>& planes) {
  std::vector<LayoutLevel> levels;
  for (const SurfacePlane& plane : planes) {
    const double up = plane.plane.normal.z();
    if (up > kLevelPlane && IsFloor(surface, plane)) AddLevel(LevelKind::kFloor, plane, levels);
    if (up < -kLevelPlane && plane.centre_m.z() > kLowestCeiling_m)
      AddLevel(LevelKind::kCeiling, plane, levels);
  }
  std::erase_if(levels, [](const LayoutLevel& level) {
    return level.kind == LevelKind::kCeiling && level.area_m2 < kCeiling_m2;
  });
  std::sort(levels.begin(), levels.end(), [](const LayoutLevel& a, const LayoutLevel& b) {
    return a.kind != b.kind ? a.kind < b.kind : a.height_m < b.height_m;
  });
  return levels;
}

std::vector<SlantedPlane> FindSlanted(const std::vector<SurfacePlane>& planes) {
  std::vector<SlantedPlane> slanted;
  for (const SurfacePlane& plane : planes) {
    const double steep = std::abs(plane.plane.normal.z());
    if (steep > kSteepest || steep < kLeastSteep || plane.area_m2 < kSlanted_m2) continue;
    slanted.push_back({plane.plane, plane.centre_m, plane.area_m2});
  }
  return slanted;
}

}  // namespace deepslam::layout
