#include "deepslam/shape/depth_view.h"

#include <algorithm>
#include <cmath>

#include "deepslam/core/wide_vectors.h"

namespace deepslam::shape {
namespace {

// Cosine of the angle under which each pixel's ray meets the surface, from depth differences over
// about 3 cm; 1 where the neighbourhood gives no surface. Not below 0.2, where depth cameras see
// nothing anyway.
Image<float> IncidenceCosine(const ObjectView& view, float near_m) {
  constexpr float kMinCosine = 0.2F;
  constexpr float kHalfWindow_m = 0.015F;
  const DepthImage& depth_m = view.depth_crop_m;
  Image<float> cosine(depth_m.width(), depth_m.height(), 1.0F);
  const auto f = static_cast<float>(view.camera.fx);
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      const float z = depth_m(u, v);
      if (!(z > near_m)) continue;
      const int step = std::clamp(static_cast<int>(kHalfWindow_m * f / z + 0.5F), 1, 8);
      if (!depth_m.Contains(u - step, v - step) || !depth_m.Contains(u + step, v + step)) continue;
      const float left = depth_m(u - step, v);
      const float right = depth_m(u + step, v);
      const float above = depth_m(u, v - step);
      const float below = depth_m(u, v + step);
      if (!(std::min({left, right, above, below}) > 0)) continue;
      // Steeper than a surface at the smallest cosine is a jump.
      const float limit = 5.0F * z * static_cast<float>(2 * step) / f + 0.02F;
      if (std::abs(right - left) > limit || std::abs(below - above) > limit) continue;
      const auto at = [&](int column, int row, float depth) {
        return view.camera.Unproject(column, row, static_cast<double>(depth));
      };
      const Eigen::Vector3d normal = (at(u + step, v, right) - at(u - step, v, left))
                                         .cross(at(u, v + step, below) - at(u, v - step, above));
      const Eigen::Vector3d ray = view.camera.Ray(u, v);
      const double length = normal.norm() * ray.norm();
      if (length > 0)
        cosine(u, v) = std::max(kMinCosine, static_cast<float>(std::abs(normal.dot(ray)) / length));
    }
  }
  return cosine;
}

}  // namespace

DepthView::DepthView(const ObjectView& view, const Pose3& camera_from_frame, Slopes slopes)
    : view_(&view) {
  if (slopes == Slopes::kMeasured) cosine_ = IncidenceCosine(view, kNear_m);
  rotation_ = camera_from_frame.rotation.toRotationMatrix().cast<float>();
  translation_ = camera_from_frame.translation_m.cast<float>();
  fx_ = static_cast<float>(view.camera.fx);
  fy_ = static_cast<float>(view.camera.fy);
  cx_ = static_cast<float>(view.camera.cx);
  cy_ = static_cast<float>(view.camera.cy);
}

DEEPSLAM_WIDE_VECTORS void DepthView::PixelsAlong(const Eigen::Vector3f& first,
                                                  const Eigen::Vector3f& step,
                                                  Line& line) const {
  const int width = view_->depth_crop_m.width();
  const float right = static_cast<float>(width) - 0.5F;
  const float bottom = static_cast<float>(view_->depth_crop_m.height()) - 0.5F;
  const float fx = fx_;
  const float fy = fy_;
  const float cx = cx_;
  const float cy = cy_;
  const std::array<float, 3> from = {first.x(), first.y(), first.z()};
  const std::array<float, 3> by = {step.x(), step.y(), step.z()};
  for (std::size_t n = 0; n < kLinePoints; ++n) {
    const auto steps = static_cast<float>(static_cast<std::int32_t>(n));
    const float z_m = from[2] + steps * by[2];
    const float u = fx * (from[0] + steps * by[0]) / z_m + cx;
    const float v = fy * (from[1] + steps * by[1]) / z_m + cy;
    const bool is_in = (z_m > kNear_m) & (u > -0.5F) & (v > -0.5F) & (u < right) & (v < bottom);
    const auto column = static_cast<std::int32_t>(is_in ? u + 0.5F : 0.0F);
    const auto row = static_cast<std::int32_t>(is_in ? v + 0.5F : 0.0F);
    line.z_m[n] = z_m;
    line.pixel[n] = is_in ? row * width + column : kNowhere;
  }
}

}  // namespace deepslam::shape
