// The result of the graph: every frame, every object and the ground in the gravity-aligned world (z
// up, ground z = 0).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "deepslam/core/quarter_turn.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam {

// One kind of edge in the energy.
struct EnergyTerm {
  std::string name;  // "r_io", "r_ij", "r_pi", "r_po", "loop"
  int num_edges = 0;
  double before = 0;  // sum of r^T Omega r, lambda included
  double after = 0;
};

struct OptimizationSummary {
  bool converged = false;
  int num_iterations = 0;
  std::string message;
  std::vector<EnergyTerm> terms;
  double ground_observed = 0;  // 1 if a ground plane entered the graph, 0 otherwise
};

struct OptimizedMap {
  std::vector<TrackedFrame>
      frames;  // every frame of the capture; between keyframes they follow rigidly
  std::vector<FrameIdx> keyframes;
  Plane ground_world;  // z = 0 when a ground was seen
  bool has_ground = false;
  ObjectMap map;
  OptimizationSummary summary;
  std::optional<QuarterTurn> upright = {};  // as in Ground
};

}  // namespace deepslam
