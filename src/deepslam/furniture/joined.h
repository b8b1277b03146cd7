// A new seat from two: the back and arms of one on the seat and legs of another.
#pragma once

#include <optional>

#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::furniture {

// How high one sits, as a share of the model's height: where the most of it is open to above
// between a quarter and two thirds. Nothing where less than a quarter of its ground plan is, as of
// stools.
[[nodiscard]] std::optional<float> SeatHeight(const VoxelGrid& shape);

struct SeatMesh {
  const TriangleMesh& mesh;  // z up, x front
  const VoxelGrid& shape;    // its solid form
  float seat_height = 0;     // share of its height, (0, 1)
};

// What lies below the seat's top of `lower`, and above it of `upper`, whose box is scaled to that
// of `lower` in ground plan; heights of both stay. Faces across the cut are cut, and what was solid
// there is closed by level faces.
[[nodiscard]] TriangleMesh JoinAtSeat(const SeatMesh& lower, const SeatMesh& upper);

}  // namespace deepslam::furniture
