// Pose graphs: the graph's own reader with all terms, and the reader of odometry.g2o.
#include <string>

#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/graph/g2o.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(g2o) {
  const auto take = [](const RelativePose&) { return Ok(); };
  if (const Status edges = artifact::DecodeG2oEdges(bytes, kFile, take); !edges.ok())
    Refused(edges.error());
  const Result<graph::G2oGraph> graph = graph::ParseG2o(bytes);
  if (!graph.ok()) return Refused(graph.error(), "line ");
  (void)graph::Chi2(*graph);
  const std::string text = graph::WriteG2o(*graph);
  const Result<graph::G2oGraph> again = graph::ParseG2o(text);
  DEEPSLAM_CHECK(again.ok(), "what was written can be read");
  return !graph->vertices.empty();
}
