#include "deepslam/synth/true_layout.h"

#include <array>
#include <cstddef>

namespace deepslam::synth {
namespace {

constexpr double kThreshold_m = 0.05;
constexpr double kWidestDoor_m = 1.4;
constexpr std::size_t kNumWalls = 4;

// From corner n to corner n + 1 runs wall n: east, north, west, south, the room to the left.
std::array<Eigen::Vector2d, kNumWalls> CornersOf(const SceneDescription& description) {
  const double x = description.room_size_m.x() / 2;
  const double y = description.room_size_m.y() / 2;
  return {Eigen::Vector2d(x, -y), {x, y}, {-x, y}, {-x, -y}};
}

OpeningKind KindOf(const SceneOpening& opening) {
  if (opening.bottom_m > kThreshold_m) return OpeningKind::kWindow;
  return opening.width_m > kWidestDoor_m ? OpeningKind::kPassage : OpeningKind::kDoor;
}

}  // namespace

Layout TrueLayout(const SceneDescription& description) {
  const std::array<Eigen::Vector2d, kNumWalls> corners = CornersOf(description);
  Layout layout;
  LayoutRoom room;
  room.polygon_m.assign(corners.begin(), corners.end());
  room.guessed.assign(kNumWalls, false);
  room.ceiling_m = description.room_size_m.z();
  room.seen_share = 1;
  room.confidence = 1;
  layout.rooms.push_back(room);
  layout.levels = {{LevelKind::kFloor, 0, AreaOf(room.polygon_m)},
                   {LevelKind::kCeiling, description.room_size_m.z(), AreaOf(room.polygon_m)}};
  for (std::size_t n = 0; n < kNumWalls; ++n) {
    LayoutWall wall;
    wall.from_m = corners[n];
    wall.to_m = corners[(n + 1) % kNumWalls];
    wall.top_m = description.room_size_m.z();
    wall.rooms = {0};
    wall.seen_share = 1;
    wall.confidence = 1;
    layout.walls.push_back(wall);
  }
  for (const SceneOpening& gap : description.openings) {
    const LayoutWall& wall = layout.walls[static_cast<std::size_t>(gap.wall)];
    const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
    LayoutOpening opening;
    opening.wall = gap.wall;
    opening.kind = KindOf(gap);
    // A gap is measured from the wall's left end as one sees it, which is where the wall ends here.
    opening.to_m = wall.to_m - gap.from_m * along;
    opening.from_m = opening.to_m - gap.width_m * along;
    opening.bottom_m = gap.bottom_m;
    opening.top_m = gap.bottom_m + gap.height_m;
    opening.rooms = {0};
    opening.confidence = 1;
    layout.openings.push_back(opening);
  }
  return layout;
}

}  // namespace deepslam::synth
