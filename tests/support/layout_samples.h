// Layouts to draw and to write: two rooms with a wall between them, a door in it, a window.
#pragma once

#include "deepslam/scene/layout.h"

namespace deepslam::testing_support {

// [0, 4] x [0, 3] and [4.1, 8.1] x [0, 3], 2.5 m high. Walls 0 to 3 are of the first room,
// beginning with the one at y = 0, walls 4 to 7 of the second. Opening 0 is a door of 0.9 m in wall
// 1, opening 1 a window of 1.2 m in wall 6.
inline Layout TwoRoomLayout() {
  Layout layout;
  for (const double x : {0.0, 4.1}) {
    LayoutRoom room;
    room.polygon_m = {{x, 0}, {x + 4, 0}, {x + 4, 3}, {x, 3}};
    room.guessed.assign(4, false);
    room.ceiling_m = 2.5;
    const int id = static_cast<int>(layout.rooms.size());
    layout.rooms.push_back(room);
    for (std::size_t n = 0; n < 4; ++n) {
      LayoutWall wall;
      wall.from_m = room.polygon_m[n];
      wall.to_m = room.polygon_m[(n + 1) % 4];
      wall.top_m = 2.5;
      wall.rooms = {id};
      wall.seen_share = 0.9;
      wall.confidence = 0.9;
      layout.walls.push_back(wall);
    }
  }
  LayoutOpening door;
  door.wall = 1;
  door.from_m = {4, 1};
  door.to_m = {4, 1.9};
  door.top_m = 2.0;
  door.rooms = {0, 1};
  door.confidence = 0.8;
  LayoutOpening window;
  window.wall = 6;
  window.kind = OpeningKind::kWindow;
  window.from_m = {7, 3};
  window.to_m = {5.8, 3};
  window.bottom_m = 0.9;
  window.top_m = 2.1;
  window.rooms = {1};
  window.confidence = 0.3;
  layout.openings = {door, window};
  return layout;
}

}  // namespace deepslam::testing_support
