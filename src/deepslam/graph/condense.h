// The graph of a long path by fewer nodes. What solving takes of memory grows with the edges, of
// which every keyframe brings a dozen; a camera that films one home for an hour must not need more
// than one that does for ten minutes.
//
// Every n keyframes that follow each other become one node, that of the first of them. The others
// keep their place beside it while the graph is solved: what lies between them is taken as true,
// since they were registered to each other many times and less than a metre is left to drift
// (mapping/refine_path.h). So a node ends where tracking did not measure from one keyframe to the
// next, and where a measurement within it contradicts the path as it is. What was measured from or
// to a keyframe is carried to its node,
//   a'_from_b' = a'_from_a a_from_b b_from_b',   Omega' = Ad(b_from_b')^T Omega Ad(b_from_b'),
// and what was measured between the same two nodes and agrees becomes one edge: their mean by
// information, with the mean information and the number of them as weight, so that robust losses
// weigh it as they would weigh each. After condensed measurements (Grisetti et al. 2012), without
// what is unsure within a node.
#pragma once

#include <functional>

#include "deepslam/graph/graph_model.h"

namespace deepslam::graph {

// Hands over measurements one after another, the same ones each time: those of a long path are made
// as they are asked for, since all of them are as large as the odometry once more.
using EachPoseEdge = std::function<void(const std::function<void(const PoseEdge&)>& use)>;

// The model with about `max_nodes` nodes for its keyframes at most (more where many of them end
// early), or as it is where it has no more; measured by what was measured `along_path` and behind
// it by its own pose edges. `model` has a node for each keyframe.
[[nodiscard]] GraphModel Condensed(GraphModel model,
                                   const EachPoseEdge& along_path,
                                   const Odometry& odometry,
                                   int max_nodes);

}  // namespace deepslam::graph
