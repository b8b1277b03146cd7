#include "deepslam/report/plan_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

#include "deepslam/scene/wall_geometry.h"

namespace deepslam::report {
namespace {

// Drawn where the other face was not seen: an inner wall's usual thickness.
constexpr double kUnknownThickness_m = 0.12;

double DistanceToEdges(const std::vector<Eigen::Vector2d>& polygon_m, const Eigen::Vector2d& p) {
  double nearest = 1e9;
  for (std::size_t n = 0; n < polygon_m.size(); ++n) {
    const Eigen::Vector2d& a = polygon_m[n];
    const Eigen::Vector2d along = polygon_m[(n + 1) % polygon_m.size()] - a;
    const double length = std::max(along.squaredNorm(), 1e-12);
    const double t = std::clamp((p - a).dot(along) / length, 0.0, 1.0);
    nearest = std::min(nearest, (p - a - t * along).norm());
  }
  return nearest;
}

// Where walls of the room stand on one of its sides, along it, in order.
std::vector<std::pair<double, double>> SpansOnSide(const Layout& layout,
                                                   int room,
                                                   const LayoutWall& side) {
  constexpr double kOnSide_m = 0.05;  // a wall of which both ends are this near to a side is on it
  std::vector<std::pair<double, double>> spans;
  for (const LayoutWall& wall : layout.walls) {
    if (std::find(wall.rooms.begin(), wall.rooms.end(), room) == wall.rooms.end()) continue;
    if (std::abs(DistanceBefore(side, wall.from_m)) > kOnSide_m ||
        std::abs(DistanceBefore(side, wall.to_m)) > kOnSide_m)
      continue;
    const Eigen::Vector2d along = AlongOf(side);
    spans.push_back(
        std::minmax({along.dot(wall.from_m - side.from_m), along.dot(wall.to_m - side.from_m)}));
  }
  std::sort(spans.begin(), spans.end());
  return spans;
}

}  // namespace

WallFrame::WallFrame(const LayoutWall& wall)
    : from_m_(wall.from_m), along_(AlongOf(wall)), inward_(-along_.y(), along_.x()) {}

double DrawnThickness(const Layout& layout, const LayoutWall& wall) {
  return ThicknessOf(layout, wall).value_or(kUnknownThickness_m);
}

std::pair<double, double> BodyOf(const Layout& layout, const LayoutWall& wall) {
  const double thickness_m = DrawnThickness(layout, wall);
  return {MeetsInHollowCorner(layout, wall, false) ? -thickness_m : 0,
          wall.length_m() + (MeetsInHollowCorner(layout, wall, true) ? thickness_m : 0)};
}

std::array<Eigen::Vector2d, 4> BodyOutline(const Layout& layout,
                                           const LayoutWall& wall,
                                           const std::pair<double, double>& span) {
  const WallFrame frame(wall);
  const double thickness_m = DrawnThickness(layout, wall);
  return {frame.At(span.first, 0),
          frame.At(span.first, -thickness_m),
          frame.At(span.second, -thickness_m),
          frame.At(span.second, 0)};
}

std::vector<std::pair<double, double>> SolidSpans(const Layout& layout, const LayoutWall& wall) {
  const auto number = static_cast<int>(&wall - layout.walls.data());
  std::vector<std::pair<double, double>> holes;
  for (const LayoutOpening& opening : layout.openings) {
    if (opening.wall == number || GoesThrough(layout, opening, wall))
      holes.push_back(SpanOf(opening, wall));
  }
  std::sort(holes.begin(), holes.end());
  auto [begin_m, end_m] = BodyOf(layout, wall);
  std::vector<std::pair<double, double>> solid;
  for (const auto& [first_m, last_m] : holes) {
    if (first_m > begin_m) solid.emplace_back(begin_m, std::min(first_m, end_m));
    begin_m = std::max(begin_m, last_m);
  }
  if (end_m > begin_m) solid.emplace_back(begin_m, end_m);
  return solid;
}

std::vector<PlanLine> UnseenSides(const Layout& layout) {
  constexpr double kShortestPiece_m = 0.1;  // what is left out
  std::vector<PlanLine> unseen;
  for (std::size_t room = 0; room < layout.rooms.size(); ++room) {
    const std::vector<Eigen::Vector2d>& corners = layout.rooms[room].polygon_m;
    for (std::size_t n = 0; n < corners.size(); ++n) {
      LayoutWall side;
      side.from_m = corners[n];
      side.to_m = corners[(n + 1) % corners.size()];
      auto spans = SpansOnSide(layout, static_cast<int>(room), side);
      spans.emplace_back(side.length_m(), side.length_m());
      const WallFrame frame(side);
      double begin_m = 0;
      for (const auto& [first_m, last_m] : spans) {
        const double end_m = std::min(first_m, side.length_m());
        if (end_m - begin_m > kShortestPiece_m)
          unseen.emplace_back(frame.At(begin_m, 0), frame.At(end_m, 0));
        begin_m = std::max(begin_m, last_m);
      }
    }
  }
  return unseen;
}

DoorLeaf LeafOf(const LayoutWall& wall, const std::pair<double, double>& span) {
  const WallFrame frame(wall);
  const bool at_begin = span.first <= wall.length_m() - span.second;
  DoorLeaf leaf;
  leaf.width_m = span.second - span.first;
  const double hinge_m = at_begin ? span.first : span.second;
  leaf.hinge_m = frame.At(hinge_m, 0);
  leaf.latch_m = frame.At(at_begin ? span.second : span.first, 0);
  leaf.open_m = frame.At(hinge_m, leaf.width_m);
  leaf.shuts_clockwise = at_begin;
  return leaf;
}

std::vector<PlanQuad> DoorSwings(const Layout& layout) {
  std::vector<PlanQuad> swings;
  for (const LayoutOpening& opening : layout.openings) {
    if (opening.kind != OpeningKind::kDoor) continue;
    const LayoutWall& wall = layout.walls[static_cast<std::size_t>(opening.wall)];
    const DoorLeaf leaf = LeafOf(wall, SpanOf(opening, wall));
    swings.push_back(
        {leaf.hinge_m, leaf.latch_m, leaf.latch_m + leaf.open_m - leaf.hinge_m, leaf.open_m});
  }
  return swings;
}

std::vector<PlanQuad> ObstaclesOf(const FloorPlanContent& content) {
  std::vector<PlanQuad> obstacles = DoorSwings(content.layout_world);
  for (const PlanThing& thing : content.things) obstacles.push_back(thing.corners_m);
  return obstacles;
}

Eigen::Vector2d FreePlace(const LayoutRoom& room, const std::vector<PlanQuad>& obstacles) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : room.polygon_m) box.extend(corner);
  constexpr double kGridStep_m = 0.15;  // a line of text on the plan
  constexpr double kMostPlaces = 40;  // a side
  const double step_m = std::max(kGridStep_m, box.sizes().maxCoeff() / kMostPlaces);
  Eigen::Vector2d best = box.center();
  double best_m = -1;
  for (double x = box.min().x() + 0.5 * step_m; x < box.max().x(); x += step_m) {
    for (double y = box.min().y() + 0.5 * step_m; y < box.max().y(); y += step_m) {
      const Eigen::Vector2d p(x, y);
      if (!IsInside(room.polygon_m, p)) continue;
      double free_m = DistanceToEdges(room.polygon_m, p);
      for (const PlanQuad& quad : obstacles) {
        const std::vector<Eigen::Vector2d> print(quad.begin(), quad.end());
        free_m = std::min(free_m, IsInside(print, p) ? 0 : DistanceToEdges(print, p));
      }
      if (free_m <= best_m) continue;
      best_m = free_m;
      best = p;
    }
  }
  return best;
}

}  // namespace deepslam::report
