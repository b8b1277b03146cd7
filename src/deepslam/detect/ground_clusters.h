// Connected clusters of what stands on the ground.
#pragma once

#include <cstddef>
#include <vector>

#include "deepslam/detect/cluster_detector.h"
#include "deepslam/detect/ground_grid.h"
#include "deepslam/geometry/box.h"

namespace deepslam::detect {

// Component of every matter cell, -1 elsewhere; components count from 0 in the order of their first
// cells.
struct Components {
  std::vector<int> of_cell;
  int count = 0;
};

[[nodiscard]] Components ConnectCells(const GroundGrid& grid);

struct Cluster {
  int component = 0;
  std::size_t num_points = 0;
  std::size_t num_cells = 0;
  int num_left = 0;  // pixels at the image's borders
  int num_right = 0;
  int num_top = 0;
  int num_rows = 0;
  Box2 box_px;
  // Of what may be furniture alone:
  std::vector<GridPoint> points;  // in image order
  std::vector<int> cells;
  double min_height_m = 0;
  double max_height_m = 0;
  double long_side_m = 0;  // on the ground
  double short_side_m = 0;
};

// Those of at least that many points, largest first; points, cells and sizes of those that may be
// furniture as far as the image and the grid tell.
[[nodiscard]] std::vector<Cluster> FindGroundClusters(int image_width,
                                                      const GroundGrid& grid,
                                                      const Components& components,
                                                      std::size_t min_points);

// Whether its size and place are those of furniture; measures the cluster, as far as it takes.
[[nodiscard]] bool IsFurniture(Cluster& cluster);

}  // namespace deepslam::detect
