// A layout as the compact map holds it, and back.
#pragma once

#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/layout.h"

namespace deepslam::presentation {

[[nodiscard]] CompactLayout CompactLayoutOf(const Layout& layout_world);

// What a compact map tells of a layout. Edges of rooms on which no wall of theirs lies are guessed;
// openings join the rooms of their walls.
[[nodiscard]] Layout LayoutOf(const CompactLayout& compact);

}  // namespace deepslam::presentation
