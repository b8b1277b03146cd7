// Things with the names that files and their elements have.
#pragma once

#include <string>
#include <vector>

#include "deepslam/simulator/simulator_scene.h"

namespace deepslam::simulator {

struct NamedThing {
  const SimulatedThing* thing = nullptr;
  std::string identifier;

  [[nodiscard]] std::string MeshFile() const { return identifier + ".obj"; }
  [[nodiscard]] std::string PieceName(std::size_t n) const {
    return identifier + "_piece_" + std::to_string(n);
  }
};

}  // namespace deepslam::simulator
