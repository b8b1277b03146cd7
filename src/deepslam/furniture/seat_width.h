// Armchairs as wide as sofas, sofas as narrow as armchairs: legs, arms and backs of the one with
// the seat of the other.
//
// Few of either are free to learn from, and their makers had the same ideas. Frame of every mesh
// and shape here: z up, x front.
#pragma once

#include "deepslam/core/random.h"
#include "deepslam/furniture/proportions.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::furniture {

// Whether something stands on both sides of the seat, above it, along most of its depth.
// `seat_height`: share of the shape's height, (0, 1); see SeatHeight.
[[nodiscard]] bool HasArms(const VoxelGrid& shape, float seat_height);

// Whether it stands on something below both sides of the seat: legs or a body, not one foot in the
// middle, which would not carry a wider seat.
[[nodiscard]] bool StandsBelowBothSides(const VoxelGrid& shape, float seat_height);

// Other proportions, with a seat 1.6 to 3.2 times as wide between arms that stay as wide as they
// were.
[[nodiscard]] Proportions DrawWidened(Random& random);

// The same with a seat 0.25 to 0.45 times as wide, for one of a sofa's two or three.
[[nodiscard]] Proportions DrawNarrowed(Random& random);

}  // namespace deepslam::furniture
