#include "deepslam/shape/front.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

namespace deepslam::shape {

int QuarterTurnsToFront(const VoxelGrid& grid) {
  int top = 0;
  int bottom = kGridSize;
  for (int n = 0; n < kGridSize * kGridSize * kGridSize; ++n) {
    if (grid.occupied[static_cast<std::size_t>(n)] == 0) continue;
    top = std::max(top, n % kGridSize + 1);
    bottom = std::min(bottom, n % kGridSize);
  }
  // Seats and mattresses lie below, arm rests rise no higher.
  constexpr double kBackBegins = 0.72;  // of the height
  const double begin = bottom + kBackBegins * (top - bottom);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0;
  Eigen::AlignedBox2d box;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = bottom; k < top; ++k) {
        if (!grid.At(i, j, k)) continue;
        box.extend(Eigen::Vector2d(i, j));
        if (k < begin) continue;
        sum += Eigen::Vector2d(i, j);
        count += 1;
      }
    }
  }
  if (count == 0) return 0;
  const Eigen::Vector2d offset =
      ((sum / count - box.center()).array() / (box.sizes().array() + 1.0)).matrix();
  // Of the footprint; a back leaning on the rim stands at 0.4, a stool's seat at 0.
  constexpr double kClear = 0.15;
  if (offset.cwiseAbs().maxCoeff() < kClear) return 0;
  if (std::abs(offset.x()) >= std::abs(offset.y())) return offset.x() > 0 ? 2 : 0;
  // Back at +y: one turn counter-clockwise brings it to -x.
  return offset.y() > 0 ? 1 : 3;
}

}  // namespace deepslam::shape
