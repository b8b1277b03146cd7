#include "deepslam/layout/build_rooms.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deepslam/layout/levels.h"
#include "deepslam/layout/mirror.h"
#include "deepslam/layout/room_outline.h"

namespace deepslam::layout {
namespace {

constexpr double kGuessedShare = 0.25;  // of a side where a wall was seen: less is a guess
// Of a room's outline that was seen as wall: less is a place outdoors, or a corner of a hall.
constexpr double kWalledShare = 0.2;
constexpr double kSeen_m = 0.3;           // of wall that makes a wall
constexpr double kNearCorner_m = 0.5;     // a wall seen up to here reaches the corner
constexpr double kLevelNormal = 0.9;      // least vertical part of a normal of floors and ceilings
constexpr double kCeilingShare = 0.03;    // of a room's area that has to be seen of its ceiling
constexpr double kOutsideFloor_m2 = 1.0;  // of the floor of a room that no camera was in
constexpr double kNearLevel_m = 0.15;     // of a vertex from its level: noise, carpets, thresholds

// What of the surface lies over a room.
struct RoomSurface {
  std::vector<std::uint32_t> vertices;
  std::vector<std::pair<double, double>> ceiling;  // height, area
};

double WeightedMedian(std::vector<std::pair<double, double>> values) {
  std::sort(values.begin(), values.end());
  double whole = 0;
  for (const auto& value : values) whole += value.second;
  double below = 0;
  for (const auto& value : values) {
    below += value.second;
    if (2 * below >= whole) return value.first;
  }
  return 0;
}

RoomSurface SurfaceOver(const CoarseSurface& surface,
                        const std::vector<double>& areas_m2,
                        const std::vector<Eigen::Vector2d>& polygon_m) {
  RoomSurface over;
  for (std::uint32_t v = 0; v < surface.mesh.vertices.size(); ++v) {
    const Eigen::Vector3d p = surface.mesh.vertices[v].cast<double>();
    if (!IsInside(polygon_m, p.head<2>())) continue;
    over.vertices.push_back(v);
    if (static_cast<double>(surface.normals[v].z()) < -kLevelNormal && p.z() > kLowestCeiling_m)
      over.ceiling.emplace_back(p.z(), areas_m2[v]);
  }
  return over;
}

// The level that most of the floor in the room is at; the lowest where none is seen.
double FloorOf(const CoarseSurface& surface,
               const std::vector<double>& areas_m2,
               const RoomSurface& over,
               const std::vector<LayoutLevel>& levels) {
  double floor_m = 0;
  double most_m2 = 0;
  for (const LayoutLevel& level : levels) {
    if (level.kind != LevelKind::kFloor) continue;
    double area_m2 = 0;
    for (const std::uint32_t v : over.vertices) {
      const auto height_m = static_cast<double>(surface.mesh.vertices[v].z());
      if (static_cast<double>(surface.normals[v].z()) > kLevelNormal &&
          std::abs(height_m - level.height_m) < kNearLevel_m)
        area_m2 += areas_m2[v];
    }
    if (area_m2 <= most_m2) continue;
    most_m2 = area_m2;
    floor_m = level.height_m;
  }
  return floor_m;
}

int ViewpointsIn(const CoarseSurface& surface, const std::vector<Eigen::Vector2d>& polygon_m) {
  return static_cast<int>(std::count_if(
      surface.viewpoints.begin(), surface.viewpoints.end(), [&](const Eigen::Vector3f& viewpoint) {
        return IsInside(polygon_m, viewpoint.head<2>().cast<double>());
      }));
}

double FloorSeenIn(const ColumnMap& columns, const std::vector<Eigen::Vector2d>& polygon_m) {
  int count = 0;
  for (int i = 0; i < columns.width; ++i) {
    for (int j = 0; j < columns.height; ++j) {
      if (columns.has_floor[columns.IndexOf(i, j)] != 0 &&
          columns.evidence[columns.IndexOf(i, j)] > 0 &&
          IsInside(polygon_m, columns.CentreOf(i, j)))
        ++count;
    }
  }
  return count * columns.cell_m * columns.cell_m;
}

double InsideShareOf(const CellComplex& complex, const CellRooms& rooms, int room) {
  double inside_m2 = 0;
  double area_m2 = 0;
  for (std::size_t cell = 0; cell < complex.cells.size(); ++cell) {
    if (rooms.room_of_cell[cell] != room) continue;
    inside_m2 += complex.cells[cell].area_m2 - complex.cells[cell].unseen_m2;
    area_m2 += complex.cells[cell].area_m2;
  }
  return area_m2 > 0 ? inside_m2 / area_m2 : 0;
}

// Positions of a side along its line, ascending.
std::pair<double, double> RangeOf(const CellComplex& complex, const OutlineSide& side) {
  const Eigen::Vector2d along = complex.lines[side.line].along();
  const double a = along.dot(side.from_m);
  const double b = along.dot(side.to_m);
  return {std::min(a, b), std::max(a, b)};
}

double WallShareOf(const CellComplex& complex, const OutlineSide& side) {
  if (side.line >= complex.num_wall_lines() || !side.faces_room) return 0;
  const auto [begin_m, end_m] = RangeOf(complex, side);
  return complex.profiles[side.line].WallShare(begin_m, end_m);
}

bool IsSeen(const CellComplex& complex, const OutlineSide& side) {
  const double share = WallShareOf(complex, side);
  return share >= kGuessedShare && share * (side.to_m - side.from_m).norm() >= kSeen_m;
}

// How high the wall was seen in a range: of the highest cells of its slots, the upper tenth's lower
// end.
double SeenTop(const WallProfile& profile, double begin_m, double end_m) {
  std::vector<double> tops_m;
  for (int slot = std::max(0, profile.SlotOf(begin_m));
       slot < std::min(profile.num_slots, profile.SlotOf(end_m) + 1);
       ++slot) {
    if (profile.is_wall[static_cast<std::size_t>(slot)] == 0) continue;
    for (int row = profile.num_rows - 1; row >= 0; --row) {
      if ((profile.at(slot, row) & kSolid) == 0) continue;
      tops_m.push_back(profile.HeightOf(row + 1));
      break;
    }
  }
  if (tops_m.empty()) return 0;
  const auto upper = tops_m.begin() + static_cast<std::ptrdiff_t>(tops_m.size() * 9 / 10);
  std::nth_element(tops_m.begin(), upper, tops_m.end());
  return *upper;
}

// Deviations of what is solid from the line, and what they leave of doubt about it.
void SetSigmas(const WallProfile& profile, double begin_m, double end_m, LayoutWall& wall) {
  constexpr double kLeastSigma_m = 0.002;  // what no depth camera of a room is better than
  double sum = 0;
  int count = 0;
  int num_slots = 0;
  for (int slot = std::max(0, profile.SlotOf(begin_m));
       slot < std::min(profile.num_slots, profile.SlotOf(end_m) + 1);
       ++slot) {
    if (profile.is_wall[static_cast<std::size_t>(slot)] == 0) continue;
    ++num_slots;
    for (int row = 0; row < profile.num_rows; ++row) {
      if ((profile.at(slot, row) & kSolid) == 0) continue;
      sum += profile.OffsetAt(slot, row) * profile.OffsetAt(slot, row);
      ++count;
    }
  }
  if (count == 0) return;
  // Noise of one column is of one view: a slot is one measurement.
  const double rms_m = std::sqrt(sum / count);
  const double length_m = num_slots * kCell_m;
  wall.offset_sigma_m = std::max(kLeastSigma_m, rms_m / std::sqrt(num_slots));
  wall.angle_sigma_rad = std::sqrt(12.0) * wall.offset_sigma_m / length_m;
}

// The wall on a range of a line.
LayoutWall WallOn(const CellComplex& complex,
                  std::size_t line,
                  const std::pair<double, double>& range) {
  const WallProfile& profile = complex.profiles[line];
  LayoutWall wall;
  wall.from_m = complex.lines[line].At(range.first);
  wall.to_m = complex.lines[line].At(range.second);
  wall.seen_share = profile.WallShare(range.first, range.second);
  wall.top_m = SeenTop(profile, range.first, range.second);
  // Half of it seen is enough to be sure of a wall; the more, the surer.
  wall.confidence = std::min(0.95, 0.4 + 0.6 * wall.seen_share);
  SetSigmas(profile, range.first, range.second, wall);
  return wall;
}

// From corner to corner where the corner is one of walls or the wall was seen nearly up to it, else
// as far as it was seen.
std::pair<double, double> SeenRange(const CellComplex& complex,
                                    const Outline& outline,
                                    std::size_t number) {
  const OutlineSide& side = outline[number];
  const WallProfile& profile = complex.profiles[side.line];
  auto [begin_m, end_m] = RangeOf(complex, side);
  double first_m = end_m;
  double last_m = begin_m;
  for (const auto& [first, end] : profile.WallRuns()) {
    if (profile.PositionOf(end) <= begin_m || profile.PositionOf(first) >= end_m) continue;
    first_m = std::min(first_m, std::max(begin_m, profile.PositionOf(first)));
    last_m = std::max(last_m, std::min(end_m, profile.PositionOf(end)));
  }
  const std::size_t size = outline.size();
  if (!IsSeen(complex, outline[(number + size - 1) % size]) && first_m - begin_m > kNearCorner_m)
    begin_m = first_m;
  if (!IsSeen(complex, outline[(number + 1) % size]) && end_m - last_m > kNearCorner_m)
    end_m = last_m;
  return {begin_m, end_m};
}

void AddWalls(const CellComplex& complex, const Outline& outline, int room, BuiltLayout& built) {
  for (std::size_t n = 0; n < outline.size(); ++n) {
    if (!IsSeen(complex, outline[n])) continue;
    LayoutWall wall = WallOn(complex, outline[n].line, SeenRange(complex, outline, n));
    const LayoutRoom& of = built.layout.rooms[static_cast<std::size_t>(room)];
    wall.rooms = {room};
    wall.bottom_m = of.floor_m;
    if (of.ceiling_m > 0) wall.top_m = of.ceiling_m;
    built.layout.walls.push_back(std::move(wall));
    built.line_of_wall.push_back(outline[n].line);
  }
}

std::optional<Outline> OuterOf(const std::vector<Outline>& outlines) {
  std::optional<Outline> outer;
  for (const Outline& outline : outlines) {
    if (!outer || AreaOf(CornersOf(outline)) > AreaOf(CornersOf(*outer))) outer = outline;
  }
  return outer;
}

// Of the wall's length the share that stands at one of these.
double KnownShareOf(const LayoutWall& wall, const std::vector<LayoutWall>& others) {
  constexpr double kBehind_m = 0.3;        // a wall's thickness: its other face is the same wall
  constexpr double kStandsBefore_m = 0.6;  // what stands this near before a wall stands at it
  constexpr double kAlongWall = 0.9;       // cosine: 26 deg
  constexpr int kPlaces = 20;              // along the wall: the share is known to 5 %
  int num_known = 0;
  for (int n = 0; n < kPlaces; ++n) {
    const Eigen::Vector2d p = wall.from_m + (n + 0.5) / kPlaces * (wall.to_m - wall.from_m);
    const bool known = std::any_of(others.begin(), others.end(), [&](const LayoutWall& other) {
      const Eigen::Vector2d along = (other.to_m - other.from_m).normalized();
      const Eigen::Vector2d off = p - other.from_m;
      const double before_m = along.x() * off.y() - along.y() * off.x();
      const double at_m = along.dot(off);
      return std::abs(along.dot((wall.to_m - wall.from_m).normalized())) > kAlongWall &&
             before_m > -kBehind_m && before_m < kStandsBefore_m && at_m > 0 &&
             at_m < other.length_m();
    });
    num_known += known ? 1 : 0;
  }
  return static_cast<double>(num_known) / kPlaces;
}

void AddImages(const Outline& outer, BuiltLayout& built) {
  for (const OutlineSide& side : outer) {
    LayoutWall image;
    image.from_m = side.from_m;
    image.to_m = side.to_m;
    built.images.push_back(std::move(image));
  }
}

// Why a room is none, or empty.
std::string WhyNot(const CoarseSurface& surface,
                   const CellComplex& complex,
                   const Outline& outer,
                   const RoomSurface& over) {
  for (const OutlineSide& side : outer) {
    if (side.line < complex.num_wall_lines() && !side.faces_room &&
        IsMirrored(surface, over.vertices, complex.lines[side.line])) {
      return "what looks like a room behind a wall is the image of the one before it, in a mirror";
    }
  }
  return {};
}

std::string LittleSeen(double area_m2, double seen_share) {
  return fmt::format("of a place of {:.1f} m^2 {:.0f} % were seen: no room is told there",
                     area_m2,
                     100 * seen_share);
}

std::string NotEntered(double area_m2) {
  return fmt::format(
      "a place of {:.1f} m^2 was not entered, and less than {:.0f} m^2 of its floor was seen: no "
      "room is told there",
      area_m2,
      kOutsideFloor_m2);
}

}  // namespace

void AddRooms(const CoarseSurface& surface,
              const ColumnMap& columns,
              const CellComplex& complex,
              const LayoutOptions& options,
              BuiltLayout& built) {
  const std::vector<double> areas_m2 = VertexAreas(surface.mesh);
  const CellRooms rooms = FindRooms(complex);
  for (int number = 0; number < rooms.num_rooms; ++number) {
    const std::vector<Outline> outlines = OutlinesOf(complex, rooms, number);
    const std::optional<Outline> outer = OuterOf(outlines);
    if (!outer) continue;
    LayoutRoom room;
    room.polygon_m = CornersOf(*outer);
    const double area_m2 = AreaOf(room.polygon_m);
    room.seen_share = InsideShareOf(complex, rooms, number);
    if (area_m2 < options.min_room_m2) continue;
    if (room.seen_share < LayoutOptions::kMinRoomSeen) {
      built.layout.notes.push_back(LittleSeen(area_m2, room.seen_share));
      continue;
    }
    const RoomSurface over = SurfaceOver(surface, areas_m2, room.polygon_m);
    const bool was_entered = ViewpointsIn(surface, room.polygon_m) > 0;
    if (!was_entered) {
      if (FloorSeenIn(columns, room.polygon_m) < kOutsideFloor_m2) {
        built.layout.notes.push_back(NotEntered(area_m2));
        continue;
      }
      if (std::string reason = WhyNot(surface, complex, *outer, over); !reason.empty()) {
        built.layout.notes.push_back(std::move(reason));
        AddImages(*outer, built);
        continue;
      }
      room.note = "seen from outside only";
    }
    double ceiling_m2 = 0;
    for (const auto& part : over.ceiling) ceiling_m2 += part.second;
    if (ceiling_m2 > kCeilingShare * area_m2) room.ceiling_m = WeightedMedian(over.ceiling);
    room.floor_m = FloorOf(surface, areas_m2, over, built.layout.levels);
    double seen_m = 0;
    double round_m = 0;
    for (const OutlineSide& side : *outer) {
      const double length_m = (side.to_m - side.from_m).norm();
      room.guessed.push_back(!IsSeen(complex, side));
      round_m += length_m;
      seen_m += length_m * WallShareOf(complex, side);
    }
    if (seen_m < kWalledShare * round_m) {
      built.layout.notes.emplace_back(
          "too little of what would bound a room was seen as wall: none is told there");
      continue;
    }
    room.confidence = (was_entered ? 1.0 : 0.5) * 0.5 * (room.seen_share + seen_m / round_m);
    const int id = static_cast<int>(built.layout.rooms.size());
    built.layout.rooms.push_back(std::move(room));
    for (const Outline& outline : outlines) AddWalls(complex, outline, id, built);
  }
}

void AddLooseWalls(const CoarseSurface& surface, const CellComplex& complex, BuiltLayout& built) {
  constexpr double kShortestLooseWall_m = 1.0;  // shorter ones are sides of wardrobes and pillars
  constexpr double kBridgedOpening_m = 1.5;     // windows and doors in it
  // What stands alone and is lower than people is a fence, a hedge, a car.
  constexpr double kLowestLooseWall_m = 1.8;
  constexpr double kKnown = 0.5;  // of its length that stands at walls which are there already
  for (std::size_t line = 0; line < complex.num_wall_lines(); ++line) {
    const WallProfile& profile = complex.profiles[line];
    std::vector<std::pair<double, double>> ranges;
    for (const auto& [first, end] : profile.WallRuns()) {
      const double begin_m = profile.PositionOf(first);
      if (ranges.empty() || begin_m - ranges.back().second > kBridgedOpening_m)
        ranges.emplace_back(begin_m, begin_m);
      ranges.back().second = profile.PositionOf(end);
    }
    for (const auto& range : ranges) {
      const LayoutWall wall = WallOn(complex, line, range);
      if (wall.length_m() < kShortestLooseWall_m || wall.seen_share < 0.5) continue;
      if (surface.has_ground && wall.top_m < kLowestLooseWall_m) continue;
      if (KnownShareOf(wall, built.layout.walls) > kKnown) continue;
      if (KnownShareOf(wall, built.images) > kKnown) continue;
      built.layout.walls.push_back(wall);
      built.layout.walls.back().confidence *= surface.has_ground ? 0.7 : 0.4;
      built.line_of_wall.push_back(line);
    }
  }
}

}  // namespace deepslam::layout
