// What a view measured along the ray through a point in space: the one lookup under everything that
// carves with depth. What that says of the point is for each asker to decide.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/point_columns.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// A ray went through a voxel whose middle lies more than this share of its side before the measured
// surface, across that; nearer to it noise decides. Half of one would leave no room for noise to a
// layer that ends at a level face.
inline constexpr float kGrazedVoxels = 0.25F;

class DepthView {
 public:
  // `view` must outlive the object; its images fit together. `camera_from_frame`: metres.
  DepthView(const ObjectView& view, const Pose3& camera_from_frame);

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

  // The same of the first `size` points of a batch, a multiple of kPointLanes. Where there is
  // nothing, `depth_m` alone says so.
  struct ReadingColumns {
    PointColumn z_m;
    PointColumn depth_m;  // 0: nothing
    PointColumn cosine;
    std::array<std::int32_t, kPointBatch> is_object;  // 0 or 1
  };
  void At(const VectorColumns& points_frame, std::size_t size, ReadingColumns& readings) const;

  // Points of a line in the camera's frame, as many as a column of a voxel grid has.
  static constexpr std::size_t kLinePoints = kGridSize;
  struct Line {
    std::array<float, kLinePoints> z_m;
    std::array<std::int32_t, kLinePoints> pixel;  // index in the crop, row by row; kNowhere
  };
  static constexpr std::int32_t kNowhere = -1;  // not before the camera or out of the crop
  // The pixels AtCamera looks at for first + n * step.
  void PixelsAlong(const Eigen::Vector3f& first, const Eigen::Vector3f& step, Line& line) const;

  // As in Reading, a pixel of the crop each.
  [[nodiscard]] const Image<float>& cosines() const { return cosine_; }

 private:
  static constexpr float kNear_m = 0.1F;  // nearer than depth cameras for rooms measure

  const ObjectView* view_;
  Image<float> cosine_;
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
  return Reading{
      p_camera.z(), measured_m, cosine_(column, row), view_->mask_crop(column, row) != 0};
}

// Here, for its callers' loops, which are compiled for wide vectors.
inline void DepthView::At(const VectorColumns& points_frame,
                          std::size_t size,
                          ReadingColumns& readings) const {
  const DepthImage& depth_m = view_->depth_crop_m;
  if (depth_m.empty()) {
    readings = {};
    return;
  }
  const int width = depth_m.width();
  const float right = static_cast<float>(width) - 0.5F;
  const float bottom = static_cast<float>(depth_m.height()) - 0.5F;
  const AffineMap camera_from_frame(rotation_, translation_);
  const float fx = fx_, fy = fy_, cx = cx_, cy = cy_;
  std::array<std::int32_t, kPointBatch> pixel, is_in_image;
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const Triple p = camera_from_frame * TripleAt(points_frame, k);
    const float u = fx * p.x / p.z + cx;
    const float v = fy * p.y / p.z + cy;
    const bool is_in = (p.z > kNear_m) & (u > -0.5F) & (v > -0.5F) & (u < right) & (v < bottom);
    const auto column = static_cast<std::int32_t>(is_in ? u + 0.5F : 0.0F);
    const auto row = static_cast<std::int32_t>(is_in ? v + 0.5F : 0.0F);
    readings.z_m[k] = p.z;
    pixel[k] = row * width + column;
    is_in_image[k] = is_in ? 1 : 0;
  }
  const float* const depths_m = depth_m.data();
  const float* const cosines = cosine_.data();
  const std::uint8_t* const in_mask = view_->mask_crop.data();
  // Without branches: what lies outside the image looks at its first pixel.
  for (std::size_t k = 0; k < size; ++k) {
    const auto n = static_cast<std::size_t>(pixel[k]);
    readings.depth_m[k] = depths_m[n];
    readings.is_object[k] = in_mask[n];
  }
  for (std::size_t k = 0; k < size; ++k)
    readings.cosine[k] = cosines[static_cast<std::size_t>(pixel[k])];
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const float measured_m = readings.depth_m[k];
    const bool is_measured = (is_in_image[k] != 0) & (measured_m > 0) &
                             (measured_m <= std::numeric_limits<float>::max());
    readings.depth_m[k] = is_measured ? measured_m : 0.0F;
    readings.is_object[k] = readings.is_object[k] != 0 ? 1 : 0;
  }
}

}  // namespace deepslam::shape
