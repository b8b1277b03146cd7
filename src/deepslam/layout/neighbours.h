// Which things stand beside each other, and which before another's front.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "deepslam/layout/relations.h"

namespace deepslam::layout {

// A thing whose neighbours are asked for.
struct PlacedThing {
  ThingBox box;
  std::optional<int> room;
  bool has_front = true;  // x of its box; false: alike from several sides
};

struct Neighbours {
  std::size_t first = 0;
  std::size_t second = 0;
  double distance_m = 0;  // between the two on the floor plan; 0: one reaches over the other
  bool beside = false;    // at one height and near; `first` is then the smaller
  bool before = false;    // the middle of `first` lies before the front of `second`
};

// Pairs that are one or the other, by `first`, then by `second`. Things in two different rooms are
// no neighbours; what has no height stands beside nothing.
[[nodiscard]] std::vector<Neighbours> NeighboursOf(std::span<const PlacedThing> things);

}  // namespace deepslam::layout
