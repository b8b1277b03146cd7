// A long path without loops, solved by overlapping sub-trajectories: memory does not grow with its
// length.
#pragma once

#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/graph/object_graph.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::mapping {

// In keyframes.
struct SubTrajectorySizes {
  int num_keyframes = 600;  // solved at a time
  int overlap = 120;        // shared with the sub-trajectory before; below num_keyframes, and at
                            // least the keyframes between the two of any edge
};

// The frames of a path whose edges join keyframes near each other in time: sub-trajectory by
// sub-trajectory, each laid on the one before in the middle of what they share. The first keyframe
// stays. Poses differ from those of the whole graph by what edges say that are half an overlap
// away. Edges out of core (more_edges) ascend by j. Errors are the optimizer's.
[[nodiscard]] Result<std::vector<TrackedFrame>> SolveSubTrajectories(
    const Odometry& odometry, const graph::GraphOptions& options, const SubTrajectorySizes& sizes);

}  // namespace deepslam::mapping
