// What stands over each place of the ground: whether it was seen as the inside of a room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/coarse_surface.h"

namespace deepslam::layout {

// Columns of the surface's voxels, x running slowest. Place (i, j) begins at origin_m + (i, j) *
// cell_m.
struct ColumnMap {
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();
  double cell_m = 1;
  int width = 0;   // along x
  int height = 0;  // along y
  // How much speaks for the inside of a room: 1 where its floor or ceiling was seen and rays passed
  // between them, less where there was nothing but free space, 0 where nothing was.
  std::vector<float> evidence;
  std::vector<std::uint8_t> has_floor;

  [[nodiscard]] std::size_t IndexOf(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(height) +
           static_cast<std::size_t>(j);
  }
  [[nodiscard]] Eigen::Vector2d CentreOf(int i, int j) const {
    return origin_m + cell_m * Eigen::Vector2d(i + 0.5, j + 0.5);
  }
};

// `floors_m`: heights of the floors people stand on.
[[nodiscard]] ColumnMap MapColumns(const CoarseSurface& surface,
                                   const std::vector<double>& floors_m);

}  // namespace deepslam::layout
