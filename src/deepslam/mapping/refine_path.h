// Behind tracking itself: keyframes that see the same are registered to each other
// (loop/covisible.h), and the path is what all measurements agree on.
#pragma once

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/loop/covisible.h"
#include "deepslam/mapping/keyframe_pyramids.h"
#include "deepslam/scene/edge_store.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::mapping {

struct RefinementOptions {
  loop::CovisibleOptions covisible;
  alignment::AlignmentOptions alignment;  // as tracking aligns
  // Keyframes over which tracking's own edges may reach: those it looks back at when it is lost.
  int most_keyframes_back = 12;
  // The odometry has edges that its poses do not follow yet (recorded_edges.h): solved in any case.
  bool has_other_edges = false;
};

// For keyframes of these frames: to be given those that tracking has read, then to RefinePath.
[[nodiscard]] KeyframePyramids PyramidsToRefine(const FrameSource& frames,
                                                const RefinementOptions& options);

// The tracked path with the poses of the graph of its cameras, and behind its own edges, in a store
// of `new_store`, those that were measured and that the solved path does not contradict. As tracked
// where it is not enabled, nothing was measured or the graph cannot be solved (with a warning).
// Keyframes that cannot be read take no part, with a warning. Beside the poses memory does not
// depend on the length of the path. Errors: Interrupted, and those of the stores.
[[nodiscard]] Result<Odometry> RefinePath(Odometry tracked,
                                          KeyframePyramids pyramids,
                                          const RefinementOptions& options,
                                          const EdgeStoreFactory& new_store,
                                          Progress& progress);

}  // namespace deepslam::mapping
