// What of a surface is the room itself: floor, ceiling, walls and what fills their openings.
#pragma once

#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/scene/layout.h"

namespace deepslam::instances {

struct StructureOptions {
  double floor_m = 0.05;        // surface this near above a floor is the floor
  double carpet_m = 0.09;       // so is what faces up this near above it
  double ceiling_m = 0.10;      // surface this near below a ceiling is the ceiling
  double wall_m = 0.06;         // surface this near to a wall, facing as it does, is the wall
  double behind_wall_m = 0.12;  // all surface this far behind a wall's face is the wall
  double leaf_m =
      0.15;  // surface this near to a door or window, before it or behind, belongs to it
};
void Describe(OptionsVisitor& visitor, StructureOptions& options);

// 1 for each element that is structure. Layout and elements are in one level world, ground z = 0.
[[nodiscard]] std::vector<char> StructureElements(const SurfaceElements& elements,
                                                  const Layout& layout,
                                                  const StructureOptions& options);

}  // namespace deepslam::instances
