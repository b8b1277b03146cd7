// Rows of sixteen voxels in an image: what fields of voxels have in common. Loops are written so
// that the compiler makes them ones of whole vectors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "deepslam/geometry/camera.h"

namespace deepslam::fuse {

inline constexpr std::size_t kRowVoxels = 16;  // a block's side

// Voxels along z, one behind the other: what a processor works on side by side.
using Row = std::array<float, kRowVoxels>;

// Where the voxels of a row lie in an image, and how far the surface measured there is ahead.
struct RowPlaces {
  std::array<std::int32_t, kRowVoxels> pixel;  // -1: not in the image, or nothing was measured
  std::array<std::int32_t, kRowVoxels> u;      // its column and row
  std::array<std::int32_t, kRowVoxels> v;
  Row ahead_m;  // along the ray
};

// The row begins at `begin_camera` and goes on by `step_camera`.
inline void PlacePixels(const PinholeCamera& camera,
                        const Eigen::Vector3f& begin_camera,
                        const Eigen::Vector3f& step_camera,
                        RowPlaces& places,
                        Row& depth_voxel_m) {
  const auto fx = static_cast<float>(camera.fx);
  const auto fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx);
  const auto cy = static_cast<float>(camera.cy);
  const float safe_width = static_cast<float>(camera.width) - 0.0001F;
  const float safe_height = static_cast<float>(camera.height) - 0.0001F;
  const std::int32_t width = camera.width;
  // Step by step, as Open3D does: where a voxel falls on the border of two pixels, the last digit
  // decides which it takes.
  Row xs;
  Row ys;
  Eigen::Vector3f p_camera = begin_camera;
  for (std::size_t n = 0; n < kRowVoxels; ++n, p_camera += step_camera) {
    xs[n] = p_camera.x();
    ys[n] = p_camera.y();
    depth_voxel_m[n] = p_camera.z();
  }
  for (std::size_t n = 0; n < kRowVoxels; ++n) {
    const float z = depth_voxel_m[n];
    const float u = xs[n] * fx / z + cx + 0.5F;
    const float v = ys[n] * fy / z + cy + 0.5F;
    // Without a branch, or the loop would not be one of whole vectors.
    const bool inside =
        (z > 0) & (u >= 0.0001F) & (u < safe_width) & (v >= 0.0001F) & (v < safe_height);
    places.u[n] = static_cast<std::int32_t>(inside ? u : 0.0F);
    places.v[n] = static_cast<std::int32_t>(inside ? v : 0.0F);
    places.pixel[n] = inside ? places.v[n] * width + places.u[n] : -1;
  }
}

}  // namespace deepslam::fuse
