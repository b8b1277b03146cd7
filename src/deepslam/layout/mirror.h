// Rooms that are seen in mirrors only.
#pragma once

#include <cstdint>
#include <vector>

#include "deepslam/layout/wall_line.h"
#include "deepslam/scene/coarse_surface.h"

namespace deepslam::layout {

// Whether most of these vertices, mirrored at the line, lie on the surface again.
[[nodiscard]] bool IsMirrored(const CoarseSurface& surface,
                              const std::vector<std::uint32_t>& vertices,
                              const WallLine& line);

}  // namespace deepslam::layout
