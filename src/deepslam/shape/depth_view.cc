#include "deepslam/shape/depth_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/point_columns.h"

namespace deepslam::shape {
namespace {

constexpr float kMinCosine = 0.2F;  // 78 degrees: beyond, depth cameras see nothing
constexpr int kMaxStep_px = 8;      // bounds the neighbourhood of what is near

// Pixels of a row whose neighbours to all four sides, `step` pixels away, lie in the image; with
// these neighbours' depths and rays.
struct Crosses {
  std::size_t size = 0;
  std::array<std::int32_t, kPointBatch> column, step;
  PointColumn z_m, left_m, right_m, above_m, below_m;
  std::array<double, kPointBatch> ray_x, ray_left, ray_right, ray_above, ray_below;
};

// A view's rays, x by column and y by row.
struct Rays {
  std::vector<double> x, y;

  explicit Rays(const ObjectView& view) {
    for (int u = 0; u < view.depth_crop_m.width(); ++u) x.push_back(view.camera.Ray(u, 0).x());
    for (int v = 0; v < view.depth_crop_m.height(); ++v) y.push_back(view.camera.Ray(0, v).y());
  }
};

// Half the width of a pixel's neighbourhood, about 1.5 cm.
void FindSteps(const float* depth_m, int width, float f, float near_m, std::int32_t* steps) {
  // Wide against depth noise, narrow against parts of furniture.
  constexpr float kHalfWindow_m = 0.015F;
  for (int u = 0; u < width; ++u) {
    const float z = depth_m[u];
    const auto step =
        static_cast<std::int32_t>(kHalfWindow_m * f / (z > near_m ? z : near_m) + 0.5F);
    const std::int32_t at_least = step > 1 ? step : 1;
    steps[u] = at_least < kMaxStep_px ? at_least : kMaxStep_px;
  }
}

void TakeNeighbours(const DepthImage& depth_m, const Rays& rays, int v, Crosses& crosses) {
  const float* const row = depth_m.row(v);
  for (std::size_t n = 0; n < crosses.size; ++n) {
    const int u = crosses.column[n];
    const int step = crosses.step[n];
    crosses.z_m[n] = row[u];
    crosses.left_m[n] = row[u - step];
    crosses.right_m[n] = row[u + step];
    crosses.above_m[n] = depth_m(u, v - step);
    crosses.below_m[n] = depth_m(u, v + step);
    const auto column = static_cast<std::size_t>(u);
    const auto line = static_cast<std::size_t>(v);
    const auto far = static_cast<std::size_t>(step);
    crosses.ray_x[n] = rays.x[column];
    crosses.ray_left[n] = rays.x[column - far];
    crosses.ray_right[n] = rays.x[column + far];
    crosses.ray_above[n] = rays.y[line - far];
    crosses.ray_below[n] = rays.y[line + far];
  }
}

// Of the angles between each pixel's ray and the surface through its neighbours; 1 where a
// neighbour is missing or lies beyond a jump.
void FindCosines(const Crosses& crosses, float f, double ray_y, PointColumn& cosines) {
#pragma GCC ivdep
  for (std::size_t n = 0; n < crosses.size; ++n) {
    const float left = crosses.left_m[n], right = crosses.right_m[n];
    const float above = crosses.above_m[n], below = crosses.below_m[n];
    // Steeper than a surface at the smallest cosine is a jump.
    const float limit = 5.0F * crosses.z_m[n] * static_cast<float>(2 * crosses.step[n]) / f + 0.02F;
    const bool is_smooth = (left > 0) & (right > 0) & (above > 0) & (below > 0) &
                           !(std::abs(right - left) > limit) & !(std::abs(below - above) > limit);
    const auto d_left = static_cast<double>(left), d_right = static_cast<double>(right);
    const auto d_above = static_cast<double>(above), d_below = static_cast<double>(below);
    const double ray_x = crosses.ray_x[n];
    const double across_x = d_right * crosses.ray_right[n] - d_left * crosses.ray_left[n];
    const double across_y = d_right * ray_y - d_left * ray_y;
    const double across_z = d_right - d_left;
    const double down_x = d_below * ray_x - d_above * ray_x;
    const double down_y = d_below * crosses.ray_below[n] - d_above * crosses.ray_above[n];
    const double down_z = d_below - d_above;
    const double x = across_y * down_z - across_z * down_y;
    const double y = across_z * down_x - across_x * down_z;
    const double z = across_x * down_y - across_y * down_x;
    const double length =
        std::sqrt(x * x + y * y + z * z) * std::sqrt(ray_x * ray_x + ray_y * ray_y + 1.0);
    const auto cosine = static_cast<float>(std::abs(x * ray_x + y * ray_y + z) / length);
    const float bounded = cosine > kMinCosine ? cosine : kMinCosine;
    cosines[n] = (is_smooth & (length > 0)) ? bounded : 1.0F;
  }
}

// Cosine of the angle under which each pixel's ray meets the surface, from depth differences over
// about 3 cm; 1 where the neighbourhood gives no surface. Not below 0.2, where depth cameras see
// nothing anyway.
DEEPSLAM_WIDE_VECTORS Image<float> IncidenceCosine(const ObjectView& view, float near_m) {
  const DepthImage& depth_m = view.depth_crop_m;
  const int width = depth_m.width();
  const int height = depth_m.height();
  Image<float> cosine(width, height, 1.0F);
  const auto f = static_cast<float>(view.camera.fx);
  const Rays rays(view);
  std::vector<std::int32_t> steps(static_cast<std::size_t>(width));
  Crosses crosses;
  PointColumn cosines;
  for (int v = 0; v < height; ++v) {
    const float* const row = depth_m.row(v);
    FindSteps(row, width, f, near_m, steps.data());
    const int to_border = std::min(v, height - 1 - v);
    for (int u = 0; u < width;) {
      for (crosses.size = 0; u < width && crosses.size < kPointBatch; ++u) {
        const std::int32_t step = steps[static_cast<std::size_t>(u)];
        crosses.column[crosses.size] = u;
        crosses.step[crosses.size] = step;
        const bool is_asked =
            (row[u] > near_m) & (step <= to_border) & (step <= u) & (step < width - u);
        crosses.size += is_asked ? 1 : 0;
      }
      TakeNeighbours(depth_m, rays, v, crosses);
      FindCosines(crosses, f, rays.y[static_cast<std::size_t>(v)], cosines);
      for (std::size_t n = 0; n < crosses.size; ++n) cosine(crosses.column[n], v) = cosines[n];
    }
  }
  return cosine;
}

}  // namespace

DepthView::DepthView(const ObjectView& view, const Pose3& camera_from_frame) : view_(&view) {
  cosine_ = IncidenceCosine(view, kNear_m);
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
