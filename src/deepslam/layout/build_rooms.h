// Rooms, walls and openings as values, from labelled cells.
#pragma once

#include <cstddef>
#include <vector>

#include "deepslam/layout/cell_complex.h"
#include "deepslam/layout/estimate_layout.h"

namespace deepslam::layout {

// A layout in the making.
struct BuiltLayout {
  Layout layout;
  std::vector<std::size_t> line_of_wall;  // of the complex, one per wall
  std::vector<LayoutWall> images;         // bounds of what mirrors show: no walls
};

// Adds rooms, and the walls around them, to a layout that has its levels. A room that no camera was
// in is kept where its floor was seen, with a note; not if it is the image of another in a mirror.
void AddRooms(const CoarseSurface& surface,
              const ColumnMap& columns,
              const CellComplex& complex,
              const LayoutOptions& options,
              BuiltLayout& built);

// Adds walls that bound no room: runs of a metre and more that do not stand before a wall that is
// there already.
void AddLooseWalls(const CoarseSurface& surface, const CellComplex& complex, BuiltLayout& built);

// Adds what opens the walls, each opening once, and says which rooms it joins; doors and passages
// out of them have a note.
void AddOpenings(const CellComplex& complex, BuiltLayout& built);

}  // namespace deepslam::layout
