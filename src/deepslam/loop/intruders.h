// Objects of the map that stand where a surer one of their class stands. Two solid things share no
// place: such an object comes from a box that took a thing and what is behind it for one, or half
// of a thing for another. The two may be seen in one frame, so that they are not merged as
// duplicates.
#pragma once

#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/scene/object_map.h"

namespace deepslam::loop {

struct Intruder {
  ObjectId id;
  ObjectId host;  // the surest of those it stands in
};

// In the order of the map. An object is one if its centre is nearer to its host's than
// overlap_share of half the smaller one's longest side, and it is less than half as sure. None
// without merge_overlapping.
[[nodiscard]] std::vector<Intruder> FindIntruders(const ObjectMap& map, const LoopOptions& options);

}  // namespace deepslam::loop
