// Solves a g2o file with the graph's own solver, for comparison with others: without robust losses,
// the first vertex held, the file's information as it stands.
//   solve_g2o IN.g2o OUT.g2o   prints the energy and whether it converged
//   solve_g2o IN.g2o           solves nothing; prints poses, edges and chi^2 by g2o's definition
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

Result<G2oGraph> Read(const char* in) {
  std::ifstream file(in);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Result<G2oGraph> graph = ParseG2o(text);
  if (!graph.ok()) std::cerr << in << ": " << graph.error().message << '\n';
  return graph;
}

int Tell(const char* in) {
  const Result<G2oGraph> graph = Read(in);
  if (!graph.ok()) return 1;
  std::printf("%zu %zu %.17g\n", graph->vertices.size(), graph->edges.size(), Chi2(*graph));
  return 0;
}

int Solve(const char* in, const char* out) {
  Result<G2oGraph> graph = Read(in);
  if (!graph.ok()) return 1;
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

int main(int argc, char** argv) {
  if (argc == 2) return deepslam::graph::Tell(argv[1]);
  return argc == 3 ? deepslam::graph::Solve(argv[1], argv[2]) : 2;
}
