// Objects of the map in one place. Two solid things share none: they are duplicates, or one of them
// is no thing of its own.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/scene/object_map.h"

namespace deepslam::loop {

// Centres nearer to each other than overlap_share of half the smaller one's longest side.
[[nodiscard]] bool SharePlace(const MapObject& a, const MapObject& b);

// An object that stands where a surer one stands, from a box that took a thing and what is behind
// it for one, or from a piece of the other. The two may be seen in one frame, so that they are not
// merged as duplicates.
struct Duplicate {
  ObjectId id;
  ObjectId host;
};

// Those less than half as sure as another one that they may touch, with every such one, in the
// order of the map. None without merge_overlapping; none of two that were seen in parts of the path
// which nothing ties together (Sightings::Tied). Parts by frame; all is one where none is given.
[[nodiscard]] std::vector<Duplicate> SuspectDuplicates(const ObjectMap& map,
                                                       const LoopOptions& options,
                                                       std::span<const int> part_of_frame = {});

// The suspects that share the place of a host of their class, or that are no more than a piece of
// the host, whatever their class: four fifths of what was measured of them lie within
// verify_distance_m of its model or of what was measured of it. Each with the surest of these
// hosts.
[[nodiscard]] std::vector<Duplicate> FindDuplicates(const std::vector<Duplicate>& suspects,
                                                    const ObjectMap& map,
                                                    const LoopEvidence& evidence);

}  // namespace deepslam::loop
