// Which frame shows each thing best, and where: for a look at what is no object of the map.
#pragma once

#include <span>
#include <vector>

#include "deepslam/instances/find_instances.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/instances/view_votes.h"
#include "deepslam/scene/object_track.h"

namespace deepslam::discovery {

// How a frame shows a thing. Its measured surface in pixels is less where it is hidden or cut off.
struct Look {
  SeenIn seen;
  double area_px = 0;  // 0: the frame shows nothing of it
};

// One per instance. `frame` is what `view` is of.
[[nodiscard]] std::vector<Look> LooksIn(FrameIdx frame,
                                        const instances::VotingView& view,
                                        const instances::SurfaceElements& elements,
                                        const instances::Instances& found,
                                        const instances::VoteOptions& options);

// Keeps the larger look at each thing, of equal ones the first. `best` may be empty before the
// first frame.
void KeepBest(std::span<const Look> looks, std::vector<Look>& best);

}  // namespace deepslam::discovery
