// What the depth images of an object's views say about points in space: free, surface of the
// object, or nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "deepslam/geometry/point_columns.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/shape/depth_view.h"

namespace deepslam::propose {

// Measurement tolerance at a depth: 1.5 cm of alignment and calibration, and noise growing with the
// square of the depth as for structured light.
[[nodiscard]] inline float DepthTolerance_m(float depth_m) {
  return 0.015F + 0.003F * depth_m * depth_m;
}

// The views of the indices `chosen`, asked about points of the level frame.
[[nodiscard]] std::vector<shape::DepthView> LevelViews(std::span<const ObjectView> views,
                                                       std::span<const std::size_t> chosen,
                                                       const Pose3& level_from_world);

// Of points side by side; at most one of the flags, each 0 or 1, is set: none for a point outside
// the crop, of invalid depth, clearly behind what was measured, or near a surface that is not the
// object's. Here, for its callers' loops, which are compiled for wide vectors.
struct EvidenceColumns {
  std::array<std::int32_t, kPointBatch> is_free;     // the ray goes on clearly behind the point
  std::array<std::int32_t, kPointBatch> is_surface;  // the object's segment lies at the point

  // What a view says of the first `size` points, a multiple of kPointLanes. `slack_m` widens the
  // tolerance across the surface (size of what is asked about): along a grazing ray it grows.
  void Take(const shape::DepthView& view,
            const VectorColumns& points_level,
            std::size_t size,
            float slack_m) {
    shape::DepthView::ReadingColumns readings;
    view.At(points_level, size, readings);
#pragma GCC ivdep
    for (std::size_t n = 0; n < size; ++n) {
      const float depth_m = readings.depth_m[n];
      const float z_m = readings.z_m[n];
      const std::int32_t is_object = readings.is_object[n];
      const float tolerance_m = DepthTolerance_m(depth_m) + slack_m / readings.cosine[n];
      const std::int32_t is_known = depth_m > 0 ? 1 : 0;
      const std::int32_t is_farther = depth_m > z_m + tolerance_m ? is_known : 0;
      const std::int32_t is_nearer = depth_m < z_m - tolerance_m ? is_known & ~is_farther : 0;
      is_free[n] = is_farther;
      is_surface[n] = is_object & is_known & ~is_farther & ~is_nearer;
    }
  }
};

}  // namespace deepslam::propose
