// The ground cut into convex cells by lines of walls (after Ochmann et al. 2016, Mura et al. 2016).
#pragma once

#include <cstddef>
#include <vector>

#include "deepslam/layout/column_map.h"
#include "deepslam/layout/wall_line.h"
#include "deepslam/layout/wall_profile.h"

namespace deepslam::layout {

struct GroundCell {
  double area_m2 = 0;    // of the columns in it
  double inside_m2 = 0;  // their evidence for the inside of a room
  double unseen_m2 = 0;  // of columns that nobody looked into
};

// A piece of a line between two crossings, and the cells at its sides.
struct CellEdge {
  std::size_t line = 0;  // behind those of the walls: the four bounds
  double begin_m = 0;    // along it
  double end_m = 0;
  std::size_t front = 0;  // cell on the line's free side
  std::size_t back = 0;
  double wall_share = 0;  // of its length, where a wall stands
  double open_share = 0;  // where rays went through and no wall stands

  [[nodiscard]] double length_m() const { return end_m - begin_m; }
};

struct CellComplex {
  std::vector<WallLine> lines;  // those of walls, then four along the first that bound what was
                                // seen
  std::vector<WallProfile> profiles;  // of the lines of walls
  std::vector<GroundCell> cells;
  std::vector<CellEdge> edges;  // line by line, in order along them

  [[nodiscard]] std::size_t num_wall_lines() const { return profiles.size(); }
};

// `lines` and `profiles` of equal size. Empty where nothing was seen inside.
[[nodiscard]] CellComplex CutGround(std::vector<WallLine> lines,
                                    std::vector<WallProfile> profiles,
                                    const ColumnMap& columns);

// Cells of rooms: number of the room per cell from 0, -1 outside. A minimum cut between what was
// seen as inside and what was not, along walls where there are any; inside cells with a wall
// between them are of different rooms.
struct CellRooms {
  std::vector<int> room_of_cell;
  int num_rooms = 0;
};
[[nodiscard]] CellRooms FindRooms(const CellComplex& complex);

}  // namespace deepslam::layout
