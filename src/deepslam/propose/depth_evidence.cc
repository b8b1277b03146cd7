#include "deepslam/propose/depth_evidence.h"

#include <cmath>

namespace deepslam::propose {
namespace {

constexpr float kNear_m = 0.1F;

}  // namespace

DepthView::DepthView(const ObjectView& view, const Pose3& level_from_world) : view_(&view) {
  const Pose3 camera_from_level = (level_from_world * view.world_from_camera).Inverse();
  rotation_ = camera_from_level.rotation.toRotationMatrix().cast<float>();
  translation_ = camera_from_level.translation_m.cast<float>();
  fx_ = static_cast<float>(view.camera.fx);
  fy_ = static_cast<float>(view.camera.fy);
  cx_ = static_cast<float>(view.camera.cx);
  cy_ = static_cast<float>(view.camera.cy);
}

Evidence DepthView::At(const Eigen::Vector3f& p_level, float slack_m) const {
  const Eigen::Vector3f p = rotation_ * p_level + translation_;
  if (!(p.z() > kNear_m)) return Evidence::kUnknown;
  const float u = fx_ * p.x() / p.z() + cx_;
  const float v = fy_ * p.y() / p.z() + cy_;
  const DepthImage& depth_m = view_->depth_crop_m;
  if (!(u > -0.5F && v > -0.5F && u < static_cast<float>(depth_m.width()) - 0.5F &&
        v < static_cast<float>(depth_m.height()) - 0.5F)) {
    return Evidence::kUnknown;
  }
  const int column = static_cast<int>(u + 0.5F);
  const int row = static_cast<int>(v + 0.5F);
  const float measured = depth_m(column, row);
  if (!(measured > 0)) return Evidence::kUnknown;
  const float tolerance = DepthTolerance_m(measured) + slack_m;
  if (measured > p.z() + tolerance) return Evidence::kFree;
  if (measured < p.z() - tolerance) return Evidence::kBehind;
  return view_->mask_crop(column, row) != 0 ? Evidence::kSurface : Evidence::kUnknown;
}

float DepthView::DepthBehind_m(const Eigen::Vector3f& p_level) const {
  const Eigen::Vector3f p = rotation_ * p_level + translation_;
  if (!(p.z() > kNear_m)) return 0;
  const float u = fx_ * p.x() / p.z() + cx_;
  const float v = fy_ * p.y() / p.z() + cy_;
  const DepthImage& depth_m = view_->depth_crop_m;
  if (!(u > -0.5F && v > -0.5F && u < static_cast<float>(depth_m.width()) - 0.5F &&
        v < static_cast<float>(depth_m.height()) - 0.5F)) {
    return 0;
  }
  const int column = static_cast<int>(u + 0.5F);
  const int row = static_cast<int>(v + 0.5F);
  const float measured = depth_m(column, row);
  return measured > 0 && view_->mask_crop(column, row) != 0 ? p.z() - measured : 0.0F;
}

}  // namespace deepslam::propose
