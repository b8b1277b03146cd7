// Objects that association re-identified where what was measured stands apart: their tracks are
// split, what each observation saw is looked for like an object of its own, and what no loop joins
// becomes whole again.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/loop/tracklets.h"
#include "deepslam/modelling/loop_world.h"
#include "deepslam/scene/loop.h"

namespace deepslam::modelling {

// The observations of re-identified objects, where they stand apart.
[[nodiscard]] Result<loop::SplitObjects> FindSplits(const LoopClosing& closing,
                                                    const LoopWorld& world);

// Objects as they were before their tracks were split, by id.
struct WholeObjects {
  Trajectory trajectory;  // at that time
  std::vector<SplitTracklet> tracklets;
  std::map<ObjectId, MapObject> objects;
  std::map<ObjectId, ObjectTrack> tracks;
  std::size_t num_made = 0;  // candidates that loops had made by then; theirs among them
};

// The observations take the places of their objects, each scored by what it saw alone.
[[nodiscard]] Result<WholeObjects> SplitTracks(const loop::SplitObjects& splits,
                                               const LoopClosing& closing,
                                               LoopWorld& world);

// These objects are whole again, and scored anew where the path has moved their views apart since.
[[nodiscard]] Status RejoinTracks(const std::set<ObjectId>& rejoined,
                                  const WholeObjects& before,
                                  const LoopClosing& closing,
                                  LoopWorld& world);

}  // namespace deepslam::modelling
