// The source's points in frame i, a batch at a time, and where they fall in its image.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/source_points.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

inline constexpr float kMinPointZM = 0.05F;  // no depth camera measures nearer

struct ProjectedPoints {
  std::size_t begin = 0;  // in SourcePoints
  std::size_t size = 0;   // a multiple of kLanes
  Column x, y, z, u, v;
  IndexColumn is_inside;  // 1; 0 where there is no depth, and outside
  IndexColumn pixel;      // the nearest one; 0 where it is not inside
};

class PointProjector {
 public:
  // Keeps a reference to the points.
  PointProjector(const PinholeCamera& camera_i, const SourcePoints& j, const Pose3& i_from_j)
      : camera_i_(camera_i),
        j_(j),
        rotation_(i_from_j.rotation.toRotationMatrix().cast<float>()),
        translation_(i_from_j.translation_m.cast<float>()) {}

  [[nodiscard]] const Eigen::Matrix3f& rotation() const { return rotation_; }
  [[nodiscard]] const Eigen::Vector3f& translation_m() const { return translation_; }

  // `use` is called with each batch in its order, or every `stride`-th one.
  template <typename Use>
  void ForBatches(const Use& use, std::size_t stride = 1) const {
    auto row = j_.rows().begin();
    ProjectedPoints projected;
    for (projected.begin = 0; projected.begin < j_.size(); projected.begin += stride * kBatch) {
      while (row != j_.rows().end() && row->begin < projected.begin) ++row;
      projected.size = std::min(kBatch, j_.size() - projected.begin);
      const std::size_t end = projected.begin + projected.size;
      for (; row != j_.rows().end() && row->begin < end; ++row) ProjectRow(*row, projected);
      use(projected);
    }
  }

 private:
  // p_i = depth * R ray + t; R ray is linear along a row.
  void ProjectRow(const SourceRow& row, ProjectedPoints& projected) const {
    const PinholeCamera& camera = j_.level().camera;
    const Eigen::Vector3f step = rotation_.col(0) / static_cast<float>(camera.fx);
    const Eigen::Vector3f start = rotation_ * camera.Ray(0, row.v).cast<float>();
    const float fx = static_cast<float>(camera_i_.fx), fy = static_cast<float>(camera_i_.fy);
    const float cx = static_cast<float>(camera_i_.cx), cy = static_cast<float>(camera_i_.cy);
    const float x0 = start.x(), y0 = start.y(), z0 = start.z();
    const float x1 = step.x(), y1 = step.y(), z1 = step.z();
    const float tx = translation_.x(), ty = translation_.y(), tz = translation_.z();
    // One pixel of border for the bilinear intensity.
    const float last_u = static_cast<float>(camera_i_.width - 1);
    const float last_v = static_cast<float>(camera_i_.height - 1);
    const std::int32_t width = camera_i_.width;
    const float* const columns = j_.column() + row.begin;
    const float* const depth = j_.depth_m() + row.begin;
    const std::size_t first = row.begin - projected.begin;
    float* const x = &projected.x[first];
    float* const y = &projected.y[first];
    float* const z = &projected.z[first];
    float* const to_u = &projected.u[first];
    float* const to_v = &projected.v[first];
    std::int32_t* const is_inside = &projected.is_inside[first];
    std::int32_t* const pixel = &projected.pixel[first];
    const std::size_t num_points = row.end - row.begin;
#pragma GCC ivdep
    for (std::size_t k = 0; k < num_points; ++k) {
      const float column = columns[k];
      x[k] = depth[k] * (x0 + column * x1) + tx;
      y[k] = depth[k] * (y0 + column * y1) + ty;
      z[k] = depth[k] * (z0 + column * z1) + tz;
      // Points at or behind the camera fall nowhere; the bound keeps the division finite.
      const float bounded_z = z[k] > kMinPointZM ? z[k] : kMinPointZM;
      const float inverse_z = 1.0F / bounded_z;
      const float at_u = fx * x[k] * inverse_z + cx;
      const float at_v = fy * y[k] * inverse_z + cy;
      const bool inside = (depth[k] > 0) & (z[k] > kMinPointZM) & (at_u >= 0) & (at_v >= 0) &
                          (at_u < last_u) & (at_v < last_v);
      to_u[k] = inside ? at_u : 0.0F;
      to_v[k] = inside ? at_v : 0.0F;
      is_inside[k] = inside ? 1 : 0;
      pixel[k] = static_cast<std::int32_t>(to_v[k] + 0.5F) * width +
                 static_cast<std::int32_t>(to_u[k] + 0.5F);
    }
  }

  const PinholeCamera& camera_i_;
  const SourcePoints& j_;
  const Eigen::Matrix3f rotation_;
  const Eigen::Vector3f translation_;
};

}  // namespace deepslam::alignment
