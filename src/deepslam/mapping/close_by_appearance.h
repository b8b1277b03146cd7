// A trajectory closed by what places look like: proposals out of `loop`, dense alignments of the
// keyframes, edges into the graph, and the path back.
#pragma once

#include <vector>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/graph/object_graph.h"
#include "deepslam/loop/appearance.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::mapping {

struct AppearanceClosing {
  loop::AppearanceOptions appearance;
  alignment::AlignmentOptions alignment;  // as tracking aligns; intensity is used in any case
  graph::GraphOptions graph;
  bool by_depth_alone = false;  // tracking used no colour: all its measurements are poor
};

// Cameras and ground as tracked, or as the graph has them with the loops' edges; in the tracking
// world either way (the first keyframe stays).
struct ClosedTrajectory {
  std::vector<TrackedFrame> frames;
  Ground ground;
  loop::AcceptedAppearance appearance;  // edges: those of adjacent keyframes behind those of loops
  int num_reregistered = 0;             // edges of adjacent keyframes
};

// Edges that the graph solved with them contradicts are refused, and it is solved again without.
// Keyframes that cannot be read take no part, with a warning. Errors: Interrupted, and those of the
// graph.
[[nodiscard]] Result<ClosedTrajectory> CloseByAppearance(const FrameSource& frames,
                                                         const Odometry& odometry,
                                                         const Ground& ground,
                                                         const AppearanceClosing& options,
                                                         Progress& progress);

}  // namespace deepslam::mapping
