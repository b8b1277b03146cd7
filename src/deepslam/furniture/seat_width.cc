#include "deepslam/furniture/seat_width.h"

#include <algorithm>
#include <optional>

namespace deepslam::furniture {

namespace {

// Shares of the box's sides.
constexpr double kSideStrip = 0.2;
constexpr double kLowestArm = 0.06;    // above the seat: cushions are not flat
constexpr double kHighestArm = 0.3;    // above the seat; what is higher is the back or its wings
constexpr double kBack = 0.25;         // what is further behind may be the back
constexpr double kLeastOfDepth = 0.4;  // of the seat in front of the back: shorter ones are no arms

struct Range {
  double from = 0;
  double to = 1;
};

constexpr Range kRightStrip = {0, kSideStrip};
constexpr Range kLeftStrip = {1 - kSideStrip, 1};

// The share of the slices across x, from `depth` on, in which anything lies within both ranges.
double ShareFilled(const VoxelGrid& shape,
                   const VoxelBox& box,
                   double depth,
                   const Range& width,
                   const Range& height) {
  const auto at = [&](int axis, double share) {
    return box.low[axis] + static_cast<int>(std::clamp(share, 0.0, 1.0) * (box.sides()[axis] - 1));
  };
  const auto any = [&](int i) {
    for (int j = at(1, width.from); j <= at(1, width.to); ++j) {
      for (int k = at(2, height.from); k <= at(2, height.to); ++k) {
        if (shape.At(i, j, k)) return true;
      }
    }
    return false;
  };
  int filled = 0;
  const int first = at(0, depth);
  for (int i = first; i <= box.high.x(); ++i) filled += any(i) ? 1 : 0;
  return static_cast<double>(filled) / (box.high.x() - first + 1);
}

// What lies within `seat` of the middle becomes `factor` times as wide, the rest keeps its width.
Proportions DrawWithSeat(double seat, double factor, Random& random) {
  Proportions drawn = DrawProportions(true, random);
  const double width = seat * factor + (1 - seat);
  drawn.width = {static_cast<float>(seat), static_cast<float>(seat * factor / width)};
  drawn.stretch.y() *= static_cast<float>(width);
  return drawn;
}

}  // namespace

bool HasArms(const VoxelGrid& shape, float seat_height) {
  const std::optional<VoxelBox> box = OccupiedBox(shape);
  if (!box) return false;
  const Range arms = {seat_height + kLowestArm, seat_height + kHighestArm};
  return ShareFilled(shape, *box, kBack, kRightStrip, arms) >= kLeastOfDepth &&
         ShareFilled(shape, *box, kBack, kLeftStrip, arms) >= kLeastOfDepth;
}

bool StandsBelowBothSides(const VoxelGrid& shape, float seat_height) {
  const std::optional<VoxelBox> box = OccupiedBox(shape);
  if (!box) return false;
  // Above what lies on the floor, as stars do, and below the seat's own thickness.
  const double height = 0.4 * seat_height;
  const Range below = {height, height};
  return ShareFilled(shape, *box, 0, kRightStrip, below) > 0 &&
         ShareFilled(shape, *box, 0, kLeftStrip, below) > 0;
}

Proportions DrawWidened(Random& random) {
  const double seat = random.Uniform(0.6, 0.75);
  const double factor = random.Uniform(1.6, 3.2);
  return DrawWithSeat(seat, factor, random);
}

Proportions DrawNarrowed(Random& random) {
  const double seat = random.Uniform(0.75, 0.85);
  const double factor = random.Uniform(0.25, 0.45);
  return DrawWithSeat(seat, factor, random);
}

}  // namespace deepslam::furniture
