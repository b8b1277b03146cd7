// Convex pieces that reach into one another, parted: an engine would throw them apart.
#pragma once

#include <vector>

#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::convex {

// Pieces of one thing, in a frame common to all.
struct PiecedThing {
  std::vector<TriangleMesh> pieces;
  bool fixed = false;  // gives way to none
};

// Where pieces of two things overlap, both are cut along a plane in the middle of the overlap (of a
// fixed thing the other one alone, and of two fixed ones none), `gap_m` apart. Pieces of which
// nothing is left are taken out. What does not overlap stays as it is.
void Separate(std::vector<PiecedThing>& things, double gap_m);

}  // namespace deepslam::convex
