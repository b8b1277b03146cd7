#include "deepslam/layout/room_outline.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "deepslam/scene/layout.h"

namespace deepslam::layout {
namespace {

constexpr double kSamePlace_m = 1e-5;  // crossings of the same lines, but for rounding
// Inner walls are as thick: shorter sides are noise between two lines.
constexpr double kShortSide_m = 0.15;
constexpr double kMaxStretch_m = 0.4;  // a corner moves this far at most when a side is taken out

std::vector<OutlineSide> BorderOf(const CellComplex& complex, const CellRooms& rooms, int room) {
  std::vector<OutlineSide> border;
  for (const CellEdge& edge : complex.edges) {
    const bool front = rooms.room_of_cell[edge.front] == room;
    const bool back = rooms.room_of_cell[edge.back] == room;
    if (front == back) continue;
    OutlineSide side{edge.line,
                     front,
                     complex.lines[edge.line].At(edge.begin_m),
                     complex.lines[edge.line].At(edge.end_m)};
    if (!front) std::swap(side.from_m, side.to_m);
    border.push_back(side);
  }
  return border;
}

// How far left one goes on, [-pi, pi].
double TurnLeft(const OutlineSide& side, const OutlineSide& next) {
  const Eigen::Vector2d a = side.to_m - side.from_m;
  const Eigen::Vector2d b = next.to_m - next.from_m;
  return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
}

// The side that goes on from the end of `side`, furthest to the left where several do: the room
// keeps together where it touches itself in a corner.
std::optional<std::size_t> NextSide(const std::vector<OutlineSide>& border,
                                    const std::vector<bool>& taken,
                                    const OutlineSide& side) {
  std::optional<std::size_t> next;
  for (std::size_t n = 0; n < border.size(); ++n) {
    if (taken[n] || (border[n].from_m - side.to_m).norm() > kSamePlace_m) continue;
    if (!next || TurnLeft(side, border[n]) > TurnLeft(side, border[*next])) next = n;
  }
  return next;
}

bool InOneLine(const OutlineSide& a, const OutlineSide& b) {
  return a.line == b.line && a.faces_room == b.faces_room;
}

void JoinSides(Outline& outline) {
  Outline joined;
  for (const OutlineSide& side : outline) {
    if (!joined.empty() && InOneLine(joined.back(), side)) {
      joined.back().to_m = side.to_m;
    } else {
      joined.push_back(side);
    }
  }
  if (joined.size() > 1 && InOneLine(joined.back(), joined.front())) {
    joined.front().from_m = joined.back().from_m;
    joined.pop_back();
  }
  outline = std::move(joined);
}

double LengthOf(const OutlineSide& side) { return (side.to_m - side.from_m).norm(); }

std::optional<Eigen::Vector2d> Meeting(const WallLine& a, const WallLine& b) {
  Eigen::Matrix2d normals;
  normals << a.normal.transpose(), b.normal.transpose();
  constexpr double kNearlyParallel = 0.26;  // sine of 15 deg
  if (std::abs(normals.determinant()) < kNearlyParallel) return std::nullopt;
  return normals.inverse() * Eigen::Vector2d(a.offset_m, b.offset_m);
}

// Takes out the side at `n` (and `n + 1` with it where `both`), and has those beside it meet.
bool TakeOut(const CellComplex& complex, std::size_t n, bool both, Outline& outline) {
  const std::size_t size = outline.size();
  const std::size_t before = (n + size - 1) % size;
  const std::size_t after = (n + (both ? 2 : 1)) % size;
  if (size < (both ? 5U : 4U)) return false;
  const auto corner =
      Meeting(complex.lines[outline[before].line], complex.lines[outline[after].line]);
  if (!corner || (*corner - outline[before].to_m).norm() > kMaxStretch_m ||
      (*corner - outline[after].from_m).norm() > kMaxStretch_m)
    return false;
  outline[before].to_m = *corner;
  outline[after].from_m = *corner;
  Outline kept;
  for (std::size_t k = 0; k < size; ++k) {
    if (k != n && !(both && k == (n + 1) % size)) kept.push_back(outline[k]);
  }
  outline = std::move(kept);
  return true;
}

// One step of taking out short sides; false when there is none that can be.
bool TakeOutShortSide(const CellComplex& complex, Outline& outline) {
  for (std::size_t n = 0; n < outline.size(); ++n) {
    if (LengthOf(outline[n]) >= kShortSide_m) continue;
    if (TakeOut(complex, n, false, outline)) return true;
    // A step in a wall: the shorter of its two halves goes as well.
    const std::size_t size = outline.size();
    const std::size_t before = (n + size - 1) % size;
    const std::size_t after = (n + 1) % size;
    const bool drop_after = LengthOf(outline[after]) < LengthOf(outline[before]);
    if (TakeOut(complex, drop_after ? n : before, true, outline)) return true;
  }
  return false;
}

}  // namespace

std::vector<Outline> OutlinesOf(const CellComplex& complex, const CellRooms& rooms, int room) {
  const std::vector<OutlineSide> border = BorderOf(complex, rooms, room);
  std::vector<bool> taken(border.size(), false);
  std::vector<Outline> outlines;
  for (std::size_t n = 0; n < border.size(); ++n) {
    if (taken[n]) continue;
    Outline outline = {border[n]};
    taken[n] = true;
    while (const auto next = NextSide(border, taken, outline.back())) {
      outline.push_back(border[*next]);
      taken[*next] = true;
    }
    if ((outline.back().to_m - outline.front().from_m).norm() > kSamePlace_m) continue;
    JoinSides(outline);
    while (TakeOutShortSide(complex, outline)) JoinSides(outline);
    if (outline.size() >= 3) outlines.push_back(std::move(outline));
  }
  return outlines;
}

std::vector<Eigen::Vector2d> CornersOf(const Outline& outline) {
  std::vector<Eigen::Vector2d> corners_m;
  for (const OutlineSide& side : outline) corners_m.push_back(side.from_m);
  return corners_m;
}

}  // namespace deepslam::layout
