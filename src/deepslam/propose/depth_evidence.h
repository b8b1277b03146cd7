// What the depth images of an object's views say about a point in space: free, surface of the
// object, or unknown.
#pragma once

#include <algorithm>
#include <optional>

#include <Eigen/Core>

#include "deepslam/scene/object_view.h"
#include "deepslam/shape/depth_view.h"

namespace deepslam::propose {

enum class Evidence {
  kUnknown,  // outside the crop, invalid depth, or near a surface that is not the object's
  kFree,     // the ray goes on clearly behind the point
  kSurface,  // the object's segment lies at the point
  kBehind,   // the ray ends before the point
};

// Measurement tolerance at a depth: 1.5 cm of alignment and calibration, and noise growing with the
// square of the depth as for structured light.
[[nodiscard]] inline float DepthTolerance_m(float depth_m) {
  return 0.015F + 0.003F * depth_m * depth_m;
}

// The view, asked about points of the level frame.
[[nodiscard]] shape::DepthView LevelView(const ObjectView& view, const Pose3& level_from_world);

struct EvidenceReading {
  Evidence evidence = Evidence::kUnknown;
  // Distance of the point behind the object's measured surface, along that surface's normal,
  // metres; 0 when it is not behind the object.
  float behind_m = 0;
};
// `slack_m` widens the tolerance across the surface (size of what is asked about): along a grazing
// ray it grows.
[[nodiscard]] inline EvidenceReading EvidenceAt(const shape::DepthView& view,
                                                const Eigen::Vector3f& p_level,
                                                float slack_m) {
  const std::optional<shape::DepthView::Reading> reading = view.At(p_level);
  if (!reading) return {};
  const float tolerance = DepthTolerance_m(reading->depth_m) + slack_m / reading->cosine;
  const float behind_m = reading->is_object
                             ? std::max(0.0F, (reading->z_m - reading->depth_m) * reading->cosine)
                             : 0.0F;
  if (reading->depth_m > reading->z_m + tolerance) return {Evidence::kFree, 0};
  if (reading->depth_m < reading->z_m - tolerance) return {Evidence::kBehind, behind_m};
  return {reading->is_object ? Evidence::kSurface : Evidence::kUnknown, behind_m};
}

}  // namespace deepslam::propose
