// Solves a g2o file with the graph's own solver, for comparison with others: without robust losses,
// the first vertex held, the file's information as it stands.
//   solve_g2o IN.g2o OUT.g2o
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>

#include "deepslam/graph/g2o.h"
#include "deepslam/graph/graph_model.h"

namespace deepslam::graph {
namespace {

GraphModel ModelOf(const G2oGraph& graph) {
  GraphModel model;
  std::map<int, int> node_of;
  for (const auto& [id, pose] : graph.vertices) {
    node_of.emplace(id, static_cast<int>(model.world_from_node.size()));
    model.world_from_node.push_back(pose);
    model.keyframes.push_back(FrameIdx{id});
  }
  for (const G2oEdge& edge : graph.edges) {
    model.pose_edges.push_back({EdgeKind::kOdometry,
                                node_of.at(edge.i),
                                node_of.at(edge.j),
                                edge.i_from_j,
                                edge.information});
  }
  return model;
}

int Solve(const char* in, const char* out) {
  std::ifstream file(in);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Result<G2oGraph> graph = ParseG2o(text);
  if (!graph.ok()) {
    std::cerr << in << ": " << graph.error().message << '\n';
    return 1;
  }
  GraphModel model = ModelOf(*graph);
  GraphOptions options;
  options.object_loss = options.odometry_loss = options.loop_loss = options.ground_loss = "none";
  options.max_iterations = 200;
  const OptimizationSummary summary = SolveGraph(model, options);
  std::size_t node = 0;
  for (auto& [id, pose] : graph->vertices) pose = model.world_from_node[node++];
  std::ofstream(out) << WriteG2o(*graph);
  double energy = 0;
  for (const EnergyTerm& term : summary.terms) energy += term.after;
  std::printf("%.17g %d\n", energy, summary.converged ? 1 : 0);
  return 0;
}

}  // namespace
}  // namespace deepslam::graph

int main(int argc, char** argv) { return argc == 3 ? deepslam::graph::Solve(argv[1], argv[2]) : 2; }
