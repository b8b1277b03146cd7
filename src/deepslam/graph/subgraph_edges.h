// The subgraph that preconditions the solution of large graphs: edges that hold every keyframe near
// where all edges together hold it, and few enough that the factor of their system stays sparse
// however often the path comes back to a place (Dellaert et al. 2010, subgraph-preconditioned
// conjugate gradients for SLAM).
#pragma once

#include <cstddef>
#include <vector>

#include "deepslam/graph/graph_model.h"

namespace deepslam::graph {

// Indices into GraphModel::pose_edges, ascending:
// - of edges between keyframes those of a spanning forest, made of the shortest along the path;
// - of the other loop edges those that reach back least, no two of which end within ten nodes:
//   they tie a round to the one before;
// - all edges to objects.
[[nodiscard]] std::vector<std::size_t> SubgraphEdges(const GraphModel& model);

}  // namespace deepslam::graph
