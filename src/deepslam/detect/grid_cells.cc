#include "deepslam/detect/grid_cells.h"

namespace deepslam::detect {

std::int64_t NumCells(Sides input, int stride) {
  return static_cast<std::int64_t>(input.width / stride) * (input.height / stride);
}

std::int64_t NumCells(Sides input) {
  std::int64_t sum = 0;
  for (const int stride : kStrides) sum += NumCells(input, stride);
  return sum;
}

std::vector<GridCell> GridCells(Sides input) {
  std::vector<GridCell> cells;
  for (const int stride : kStrides) {
    for (int v = 0; v < input.height / stride; ++v) {
      for (int u = 0; u < input.width / stride; ++u) cells.push_back({u, v, stride});
    }
  }
  return cells;
}

}  // namespace deepslam::detect
