// Floors and ceilings, and planes that neither stand nor lie.
#pragma once

#include <vector>

#include "deepslam/layout/surface_planes.h"
#include "deepslam/scene/layout.h"

namespace deepslam::layout {

// Above the ground: what faces down lower is the underside of furniture or of a sloped roof.
inline constexpr double kLowestCeiling_m = 1.8;

// Floors, ascending, then ceilings, ascending. The ground is a floor where it was seen; what lies
// below it is one from half a square metre on; what lies above only where cameras rose by it as they
// were carried over it, for tables and beds are flat too.
[[nodiscard]] std::vector<LayoutLevel> FindLevels(const CoarseSurface& surface,
                                                  const std::vector<SurfacePlane>& planes);

// By area, largest first.
[[nodiscard]] std::vector<SlantedPlane> FindSlanted(const std::vector<SurfacePlane>& planes);

}  // namespace deepslam::layout
