// What a view measured along the ray through a point in space: the one lookup under everything that
// carves with depth. What that says of the point is for each asker to decide.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

class DepthView {
 public:
  enum class Slopes { kMeasured, kIgnored };  // ignored: every cosine is 1

  // `view` must outlive the object; its images fit together. `camera_from_frame`: metres.
  DepthView(const ObjectView& view,
            const Pose3& camera_from_frame,
            Slopes slopes = Slopes::kMeasured);

  struct Reading {
    float z_m = 0;      // of the point, along the camera's axis
    float depth_m = 0;  // measured in its pixel, finite, > 0
    // Of the angle between ray and measured surface; 1 where the neighbourhood gives no surface,
    // not below 0.2, where depth cameras see nothing anyway.
    float cosine = 1;
    bool is_object = false;  // the pixel is of the object's segment
  };
  // Nothing when the point is not before the camera or out of the crop, or nothing was measured.
  [[nodiscard]] std::optional<Reading> At(const Eigen::Vector3f& p_frame) const {
    return AtCamera(rotation_ * p_frame + translation_);
  }
  // The same of a point in the camera's frame.
  [[nodiscard]] std::optional<Reading> AtCamera(const Eigen::Vector3f& p_camera) const;

  // Points of a line in the camera's frame, as many as a column of a voxel grid has.
  static constexpr std::size_t kLinePoints = kGridSize;
  struct Line {
    std::array<float, kLinePoints> z_m;
    std::array<std::int32_t, kLinePoints> pixel;  // index in the crop, row by row; kNowhere
  };
  static constexpr std::int32_t kNowhere = -1;  // not before the camera or out of the crop
  // The pixels AtCamera looks at for first + n * step.
  void PixelsAlong(const Eigen::Vector3f& first, const Eigen::Vector3f& step, Line& line) const;

 private:
  static constexpr float kNear_m = 0.1F;

  const ObjectView* view_;
  Image<float> cosine_;       // empty where slopes are ignored
  Eigen::Matrix3f rotation_;  // camera from frame
  Eigen::Vector3f translation_;
  float fx_, fy_, cx_, cy_;
};

// Here, since it is asked millions of times an object.
inline std::optional<DepthView::Reading> DepthView::AtCamera(
    const Eigen::Vector3f& p_camera) const {
  if (!(p_camera.z() > kNear_m)) return std::nullopt;
  const float u = fx_ * p_camera.x() / p_camera.z() + cx_;
  const float v = fy_ * p_camera.y() / p_camera.z() + cy_;
  const DepthImage& depth_m = view_->depth_crop_m;
  if (!(u > -0.5F && v > -0.5F && u < static_cast<float>(depth_m.width()) - 0.5F &&
        v < static_cast<float>(depth_m.height()) - 0.5F)) {
    return std::nullopt;
  }
  const int column = static_cast<int>(u + 0.5F);
  const int row = static_cast<int>(v + 0.5F);
  const float measured_m = depth_m(column, row);
  if (!(measured_m > 0) || !std::isfinite(measured_m)) return std::nullopt;
  return Reading{p_camera.z(),
                 measured_m,
                 cosine_.empty() ? 1.0F : cosine_(column, row),
                 view_->mask_crop(column, row) != 0};
}

}  // namespace deepslam::shape
