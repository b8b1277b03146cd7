#include "deepslam/presentation/compact_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

#include "deepslam/scene/wall_geometry.h"

namespace deepslam::presentation {
namespace {

// A wall lies on an edge that it is this near to, over half of the edge's length.
constexpr double kOnEdge_m = 0.15;
constexpr double kOfEdge = 0.5;  // share of its length

bool LiesOn(const LayoutWall& wall, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const double length_m = (b - a).norm();
  if (!(length_m > 0)) return false;
  const Eigen::Vector2d along = (b - a) / length_m;
  const auto before = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d off = p - a;
    return std::abs(along.x() * off.y() - along.y() * off.x());
  };
  if (before(wall.from_m) > kOnEdge_m || before(wall.to_m) > kOnEdge_m) return false;
  const double first = along.dot(wall.from_m - a);
  const double second = along.dot(wall.to_m - a);
  const double covered_m =
      std::min(length_m, std::max(first, second)) - std::max(0.0, std::min(first, second));
  return covered_m >= kOfEdge * length_m;
}

void MarkGuessed(const std::vector<LayoutWall>& walls, int id, LayoutRoom& room) {
  const std::size_t size = room.polygon_m.size();
  for (std::size_t n = 0; n < size; ++n) {
    const bool has_wall = std::any_of(walls.begin(), walls.end(), [&](const LayoutWall& wall) {
      return std::find(wall.rooms.begin(), wall.rooms.end(), id) != wall.rooms.end() &&
             LiesOn(wall, room.polygon_m[n], room.polygon_m[(n + 1) % size]);
    });
    room.guessed.push_back(!has_wall);
  }
}

}  // namespace

CompactLayout CompactLayoutOf(const Layout& layout_world) {
  CompactLayout compact;
  for (const LayoutRoom& room : layout_world.rooms) {
    compact.rooms.push_back({room.polygon_m, room.floor_m, std::nullopt});
    if (HasCeiling(room)) compact.rooms.back().ceiling_m = room.ceiling_m;
  }
  for (const LayoutWall& wall : layout_world.walls) {
    compact.walls.push_back({wall.rooms,
                             wall.from_m,
                             wall.to_m,
                             wall.bottom_m,
                             std::max(wall.bottom_m, wall.top_m),
                             wall.seen_share,
                             wall.confidence});
  }
  for (const LayoutOpening& opening : layout_world.openings) {
    compact.openings.push_back({opening.wall,
                                opening.kind,
                                opening.from_m,
                                opening.to_m,
                                opening.bottom_m,
                                std::max(opening.bottom_m, opening.top_m),
                                opening.confidence});
  }
  return compact;
}

Layout LayoutOf(const CompactLayout& compact) {
  Layout layout;
  for (const CompactWall& wall : compact.walls) {
    LayoutWall& out = layout.walls.emplace_back();
    out.from_m = wall.from_m;
    out.to_m = wall.to_m;
    out.bottom_m = wall.bottom_m;
    out.top_m = wall.top_m;
    out.rooms = wall.rooms;
    out.seen_share = wall.seen_share;
    out.confidence = wall.confidence;
  }
  for (const CompactRoom& room : compact.rooms) {
    LayoutRoom out;
    out.polygon_m = room.polygon_m;
    out.floor_m = room.floor_m;
    out.ceiling_m = room.ceiling_m.value_or(0);
    MarkGuessed(layout.walls, static_cast<int>(layout.rooms.size()), out);
    layout.rooms.push_back(std::move(out));
  }
  for (const CompactOpening& opening : compact.openings) {
    LayoutOpening& out = layout.openings.emplace_back();
    out.wall = opening.wall;
    out.kind = opening.kind;
    out.from_m = opening.from_m;
    out.to_m = opening.to_m;
    out.bottom_m = opening.bottom_m;
    out.top_m = opening.top_m;
    out.confidence = opening.confidence;
    out.rooms = layout.walls[static_cast<std::size_t>(opening.wall)].rooms;
  }
  return layout;
}

}  // namespace deepslam::presentation
