#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>

#include "deepslam/core/disjoint_sets.h"
#include "deepslam/layout/cell_complex.h"

namespace deepslam::layout {
namespace {

// All in square metres of cells that are labelled against what was seen of them.
constexpr double kUnseenInside = 0.35;    // per m^2 of a room that nobody looked into
constexpr double kOpenBorder_m = 0.35;    // per m of border where rays went through
constexpr double kUnseenBorder_m = 0.16;  // per m of border where nothing tells of a wall
constexpr double kFace_m =
    0.5;  // per m of wall that has the outside before it, or a room behind it
constexpr double kLeastCost = 1e-3;  // keeps cells of which nothing is known with their neighbours
constexpr double kParts = 0.5;       // a wall this long between two cells parts rooms

using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;
using FlowGraph = boost::adjacency_list<
    boost::vecS,
    boost::vecS,
    boost::directedS,
    boost::property<boost::vertex_index_t,
                    long,
                    boost::property<boost::vertex_color_t,
                                    boost::default_color_type,
                                    boost::property<boost::vertex_distance_t,
                                                    long,
                                                    boost::property<boost::vertex_predecessor_t,
                                                                    Traits::edge_descriptor>>>>,
    boost::property<
        boost::edge_capacity_t,
        double,
        boost::property<boost::edge_residual_capacity_t,
                        double,
                        boost::property<boost::edge_reverse_t, Traits::edge_descriptor>>>>;

void AddArc(std::size_t from, std::size_t to, double capacity, double back, FlowGraph& graph) {
  const auto forward = boost::add_edge(from, to, graph).first;
  const auto reverse = boost::add_edge(to, from, graph).first;
  boost::put(boost::edge_capacity, graph, forward, capacity);
  boost::put(boost::edge_capacity, graph, reverse, back);
  boost::put(boost::edge_reverse, graph, forward, reverse);
  boost::put(boost::edge_reverse, graph, reverse, forward);
}

// What it costs to call a cell outside, or inside.
struct CellCosts {
  std::vector<double> outside;
  std::vector<double> inside;
};

CellCosts CostsOf(const CellComplex& complex) {
  CellCosts costs;
  for (const GroundCell& cell : complex.cells) {
    costs.outside.push_back(cell.inside_m2);
    costs.inside.push_back(kUnseenInside * cell.unseen_m2);
  }
  for (const CellEdge& edge : complex.edges) {
    const double face = kFace_m * edge.length_m() * edge.wall_share;
    costs.outside[edge.front] += face;
    costs.inside[edge.back] += face;
    if (edge.line >= complex.num_wall_lines()) {
      // Beyond the bounds there is nothing.
      costs.inside[edge.back] += 1e6;
    }
  }
  return costs;
}

std::vector<bool> InsideCells(const CellComplex& complex) {
  const std::size_t num_cells = complex.cells.size();
  const std::size_t source = num_cells;
  const std::size_t sink = num_cells + 1;
  FlowGraph graph(num_cells + 2);
  const CellCosts costs = CostsOf(complex);
  for (std::size_t cell = 0; cell < num_cells; ++cell) {
    AddArc(source, cell, costs.outside[cell], 0, graph);
    AddArc(cell, sink, costs.inside[cell], 0, graph);
  }
  for (const CellEdge& edge : complex.edges) {
    const double unseen_share = std::max(0.0, 1 - edge.wall_share - edge.open_share);
    // The bounds are no reason to go on or to stop: what was seen ends there.
    const bool is_bound = edge.line >= complex.num_wall_lines();
    const double border =
        is_bound
            ? 0
            : edge.length_m() * (kOpenBorder_m * edge.open_share + kUnseenBorder_m * unseen_share);
    AddArc(edge.front, edge.back, border + kLeastCost, border + kLeastCost, graph);
  }
  boost::boykov_kolmogorov_max_flow(graph, source, sink);
  const auto colours = boost::get(boost::vertex_color, graph);
  const auto of_source = boost::get(colours, source);
  std::vector<bool> inside(num_cells);
  for (std::size_t cell = 0; cell < num_cells; ++cell)
    inside[cell] = boost::get(colours, cell) == of_source;
  return inside;
}

}  // namespace

CellRooms FindRooms(const CellComplex& complex) {
  CellRooms rooms;
  rooms.room_of_cell.assign(complex.cells.size(), -1);
  if (complex.cells.empty()) return rooms;
  const std::vector<bool> inside = InsideCells(complex);
  DisjointSets sets(complex.cells.size());
  for (const CellEdge& edge : complex.edges) {
    if (inside[edge.front] && inside[edge.back] && edge.wall_share < kParts) {
      sets.Join(static_cast<std::uint32_t>(edge.front), static_cast<std::uint32_t>(edge.back));
    }
  }
  for (std::size_t cell = 0; cell < complex.cells.size(); ++cell) {
    if (!inside[cell]) continue;
    const std::size_t least = sets.LeastOf(static_cast<std::uint32_t>(cell));
    if (least == cell) rooms.room_of_cell[cell] = rooms.num_rooms++;
    rooms.room_of_cell[cell] = rooms.room_of_cell[least];
  }
  return rooms;
}

}  // namespace deepslam::layout
