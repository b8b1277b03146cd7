#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "deepslam/layout/build_rooms.h"
#include "deepslam/layout/wall_openings.h"

namespace deepslam::layout {
namespace {

constexpr double kThickest_m = 0.5;     // wall between two faces of one opening
constexpr double kSameFace_m = 0.2;     // between lines that one face was told on
constexpr double kBehindStep_m = 0.25;  // steps in which the room behind an opening is looked for
constexpr int kMostBehindSteps = 4;  // up to 1 m: rooms that begin later are not behind that wall

// The room behind an opening in a wall; -1 where there is none.
int RoomBehind(const Layout& layout, const LayoutWall& wall, const Eigen::Vector2d& middle) {
  const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
  const Eigen::Vector2d behind(along.y(), -along.x());
  for (int step = 1; step <= kMostBehindSteps; ++step) {
    const Eigen::Vector2d p = middle + step * kBehindStep_m * behind;
    for (std::size_t room = 0; room < layout.rooms.size(); ++room) {
      const bool is_own = std::find(wall.rooms.begin(), wall.rooms.end(), static_cast<int>(room)) !=
                          wall.rooms.end();
      if (!is_own && IsInside(layout.rooms[room].polygon_m, p)) return static_cast<int>(room);
    }
  }
  return -1;
}

// Whether both are the two faces of one opening, or one face told twice: by the wall of a room and
// by one that reaches beyond it.
bool AreOne(const Layout& layout, const LayoutOpening& a, const LayoutOpening& b) {
  const LayoutWall& wall_a = layout.walls[static_cast<std::size_t>(a.wall)];
  const LayoutWall& wall_b = layout.walls[static_cast<std::size_t>(b.wall)];
  const Eigen::Vector2d along_a = (wall_a.to_m - wall_a.from_m).normalized();
  const Eigen::Vector2d along_b = (wall_b.to_m - wall_b.from_m).normalized();
  constexpr double kParallelFaces = 0.95;  // cosine: 18 deg
  const double turned = along_a.dot(along_b);
  if (std::abs(turned) < kParallelFaces) return false;
  const double apart_m = turned < 0 ? kThickest_m : kSameFace_m;
  const Eigen::Vector2d between = 0.5 * (b.from_m + b.to_m) - 0.5 * (a.from_m + a.to_m);
  const double shift_m = std::abs(along_a.dot(between));
  const double thickness_m = std::abs(along_a.x() * between.y() - along_a.y() * between.x());
  return thickness_m < apart_m && 2 * shift_m < (a.to_m - a.from_m).norm();
}

// Doors and passages behind which no room is told say so, once for all in the notes.
void TellWhatWasNotEntered(Layout& layout) {
  int count = 0;
  for (LayoutOpening& opening : layout.openings) {
    if (opening.kind == OpeningKind::kWindow || opening.rooms.size() != 1) continue;
    ++count;
    if (opening.note.empty()) opening.note = "behind it no room is told: nobody went there";
  }
  if (count > 0) {
    layout.notes.push_back(fmt::format(
        "{} of {} openings lead out of the rooms that were entered; what lies behind is not told",
        count,
        layout.openings.size()));
  }
}

}  // namespace

void AddOpenings(const CellComplex& complex, BuiltLayout& built) {
  Layout& layout = built.layout;
  std::vector<LayoutOpening> found;
  for (std::size_t n = 0; n < layout.walls.size(); ++n) {
    const LayoutWall& wall = layout.walls[n];
    const std::size_t line_number = built.line_of_wall[n];
    const WallLine& line = complex.lines[line_number];
    const bool ceiling_seen =
        !wall.rooms.empty() && layout.rooms[static_cast<std::size_t>(wall.rooms[0])].ceiling_m > 0;
    const WallFace face{line.along().dot(wall.from_m),
                        line.along().dot(wall.to_m),
                        wall.bottom_m,
                        wall.top_m,
                        ceiling_seen};
    for (FaceOpening& opening : FindOpenings(complex.profiles[line_number], face)) {
      LayoutOpening placed;
      placed.wall = static_cast<int>(n);
      placed.kind = opening.kind;
      placed.from_m = line.At(opening.from_m);
      placed.to_m = line.At(opening.to_m);
      placed.bottom_m = opening.bottom_m;
      placed.top_m = opening.top_m;
      placed.rooms = wall.rooms;
      placed.confidence = opening.confidence;
      placed.note = std::move(opening.note);
      const int behind = RoomBehind(layout, wall, 0.5 * (placed.from_m + placed.to_m));
      if (behind >= 0 && placed.kind != OpeningKind::kWindow) placed.rooms.push_back(behind);
      found.push_back(std::move(placed));
    }
  }
  for (LayoutOpening& opening : found) {
    const auto other =
        std::find_if(layout.openings.begin(), layout.openings.end(), [&](const auto& known) {
          return AreOne(layout, known, opening);
        });
    if (other == layout.openings.end()) {
      layout.openings.push_back(std::move(opening));
    } else if (opening.confidence > other->confidence) {
      *other = std::move(opening);
    }
  }
  TellWhatWasNotEntered(layout);
}

}  // namespace deepslam::layout
