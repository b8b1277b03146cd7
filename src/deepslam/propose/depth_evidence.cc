#include "deepslam/propose/depth_evidence.h"

#include <algorithm>
#include <optional>

namespace deepslam::propose {

shape::DepthView LevelView(const ObjectView& view, const Pose3& level_from_world) {
  return {view, (level_from_world * view.world_from_camera).Inverse()};
}

EvidenceReading EvidenceAt(const shape::DepthView& view,
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
