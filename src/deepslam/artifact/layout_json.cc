#include "deepslam/artifact/layout_json.h"

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/artifact/scene_json.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/layout", 1};
constexpr Range kArea_m2{0, 1e12};
constexpr Range kSigma{0, 1e6};
constexpr std::array<std::string_view, 2> kLevelKinds{"floor", "ceiling"};
constexpr std::array<std::string_view, 3> kOpeningKinds{"door", "window", "passage"};

void Describe(JsonVisitor& visitor, OpeningKind& kind) { visitor.Choice(kind, kOpeningKinds); }

void Describe(JsonVisitor& visitor, Eigen::Vector2d& place_m) {
  visitor.Numbers(std::span<double>(place_m.data(), 2));
  if (!(place_m.cwiseAbs().array() < kPlanPlace_m.max).all()) visitor.Fail({}, "is no place");
}

void DescribePolygon(JsonVisitor& visitor, std::vector<Eigen::Vector2d>& polygon_m) {
  std::vector<double> numbers;
  for (const Eigen::Vector2d& corner : polygon_m)
    numbers.insert(numbers.end(), {corner.x(), corner.y()});
  visitor.Field("polygon_m", numbers, kPlanPlace_m);
  if (!visitor.reading()) return;
  if (numbers.size() < 6 || numbers.size() % 2 != 0)
    visitor.Fail("polygon_m", "must be x, y of three corners or more");
  polygon_m.clear();
  for (std::size_t n = 0; n + 1 < numbers.size(); n += 2)
    polygon_m.emplace_back(numbers[n], numbers[n + 1]);
}

void CheckRooms(JsonVisitor& visitor,
                std::string_view member,
                const std::vector<int>& rooms,
                std::size_t num_rooms) {
  for (const int room : rooms) {
    if (room < 0 || static_cast<std::size_t>(room) >= num_rooms)
      visitor.Fail(member, "names a room that is not there");
  }
}

void Describe(JsonVisitor& visitor, LevelKind& kind) { visitor.Choice(kind, kLevelKinds); }

void DescribeCeiling(JsonVisitor& visitor, LayoutRoom& room) {
  std::optional<double> ceiling_m;  // null: not seen
  if (HasCeiling(room)) ceiling_m = room.ceiling_m;
  visitor.Maybe("ceiling_m", ceiling_m);
  if (!visitor.reading() || !ceiling_m) return;
  if (!(*ceiling_m > room.floor_m && *ceiling_m < kPlanPlace_m.max))
    visitor.Fail("ceiling_m", "must be above floor_m");
  room.ceiling_m = *ceiling_m;
}

void Describe(JsonVisitor& visitor, LayoutRoom& room) {
  DescribePolygon(visitor, room.polygon_m);
  visitor.Field("guessed", room.guessed);
  if (room.guessed.size() != room.polygon_m.size())
    visitor.Fail("guessed", "must have one value per corner of the polygon");
  visitor.WriteOnly("area_m2", AreaOf(room.polygon_m));
  visitor.Field("floor_m", room.floor_m, kPlanPlace_m);
  DescribeCeiling(visitor, room);
  visitor.Field("seen_share", room.seen_share, kShare);
  visitor.Field("confidence", room.confidence, kShare);
  visitor.Maybe("note", room.note, !room.note.empty());
}

void Describe(JsonVisitor& visitor, LayoutWall& wall) {
  visitor.Field("from_m", wall.from_m);
  visitor.Field("to_m", wall.to_m);
  DescribeHeights(visitor, wall);
  visitor.Field("rooms", wall.rooms);
  visitor.Field("seen_share", wall.seen_share, kShare);
  visitor.Field("confidence", wall.confidence, kShare);
  visitor.Field("offset_sigma_m", wall.offset_sigma_m, kSigma);
  visitor.Field("angle_sigma_rad", wall.angle_sigma_rad, kSigma);
}

void Describe(JsonVisitor& visitor, LayoutOpening& opening) {
  visitor.Field("wall", opening.wall);
  visitor.Field("kind", opening.kind);
  visitor.Field("from_m", opening.from_m);
  visitor.Field("to_m", opening.to_m);
  DescribeHeights(visitor, opening);
  visitor.Field("rooms", opening.rooms);
  visitor.Field("confidence", opening.confidence, kShare);
  visitor.Maybe("note", opening.note, !opening.note.empty());
}

void Describe(JsonVisitor& visitor, LayoutLevel& level) {
  visitor.Field("kind", level.kind);
  visitor.Field("height_m", level.height_m, kPlanPlace_m);
  visitor.Field("area_m2", level.area_m2, kArea_m2);
}

void Describe(JsonVisitor& visitor, SlantedPlane& slanted) {
  visitor.Field("plane", slanted.plane);
  visitor.Field("centre_m", slanted.centre_m);
  visitor.Field("area_m2", slanted.area_m2, kArea_m2);
}

void CheckIds(JsonVisitor& visitor, const Layout& layout) {
  for (const LayoutWall& wall : layout.walls)
    CheckRooms(visitor, "walls", wall.rooms, layout.rooms.size());
  for (const LayoutOpening& opening : layout.openings) {
    CheckRooms(visitor, "openings", opening.rooms, layout.rooms.size());
    if (static_cast<std::size_t>(opening.wall) >= layout.walls.size())
      visitor.Fail("openings", "names a wall that is not there");
  }
}

void Describe(JsonVisitor& visitor, Layout& layout) {
  visitor.Field("rooms", layout.rooms);
  visitor.Field("walls", layout.walls);
  visitor.Field("openings", layout.openings);
  visitor.Field("levels", layout.levels);
  visitor.Field("slanted", layout.slanted);
  visitor.Field("level_from_tracking", layout.level_from_tracking);
  visitor.Field("notes", layout.notes);
  if (visitor.reading()) CheckIds(visitor, layout);
}

Result<std::string> EncodeLayout(const Layout& layout, std::string_view name) {
  return EncodeDocument(kFormat, layout, name);
}

Result<Layout> DecodeLayout(TextSource text, std::string_view name) {
  return DecodeDocument<Layout>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
