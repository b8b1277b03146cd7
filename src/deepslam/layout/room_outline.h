// The outline of rooms, corner by corner along the lines that bound them.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "deepslam/layout/cell_complex.h"

namespace deepslam::layout {

// A straight side of a room, the room to its left.
struct OutlineSide {
  std::size_t line = 0;    // of the complex
  bool faces_room = true;  // the line's free side is the room's
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
};

// A closed loop of sides, each beginning where the last one ended.
using Outline = std::vector<OutlineSide>;

// Loops around the cells of a room: counter-clockwise around it, clockwise around what stands in it
// (pillars). Sides in one line are one; those too short to be told from the width of the lines
// (0.15 m) are taken out where the sides beside them can be lengthened to meet.
[[nodiscard]] std::vector<Outline> OutlinesOf(const CellComplex& complex,
                                              const CellRooms& rooms,
                                              int room);

[[nodiscard]] std::vector<Eigen::Vector2d> CornersOf(const Outline& outline);

}  // namespace deepslam::layout
