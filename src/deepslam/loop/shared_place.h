// Objects of the map in one place. Two solid things share none: they are duplicates, or one of them
// is no thing of its own.
#pragma once

#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/scene/object_map.h"

namespace deepslam::loop {

// Of one class, with centres nearer to each other than overlap_share of half the smaller one's
// longest side.
[[nodiscard]] bool SharePlace(const MapObject& a, const MapObject& b, const LoopOptions& options);

// An object that stands where a surer one stands, from a box that took a thing and what is behind
// it for one. The two may be seen in one frame, so that they are not merged as duplicates.
struct Intruder {
  ObjectId id;
  ObjectId host;  // the surest of those it shares its place with
};

// In the order of the map: those less than half as sure as their host. None without
// merge_overlapping.
[[nodiscard]] std::vector<Intruder> FindIntruders(const ObjectMap& map, const LoopOptions& options);

}  // namespace deepslam::loop
