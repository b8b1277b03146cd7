#include "deepslam/artifact/layout_json.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/layout";
constexpr int kVersion = 1;
constexpr double kMaxPlace_m = 1e6;
constexpr double kMaxArea_m2 = 1e12;

JsonValue ToJson(const Eigen::Vector2d& p) { return JsonArray{p.x(), p.y()}; }

Eigen::Vector2d ReadPlace(const JsonNode& node) {
  const std::vector<double> xy = node.Numbers(2);
  if (!(std::abs(xy[0]) < kMaxPlace_m && std::abs(xy[1]) < kMaxPlace_m)) node.Fail("is no place");
  return {xy[0], xy[1]};
}

double ReadHeight(const JsonNode& node) { return node.Number(-kMaxPlace_m, kMaxPlace_m); }

JsonValue RoomIds(const std::vector<int>& rooms) {
  JsonArray ids;
  for (const int room : rooms) ids.emplace_back(room);
  return JsonValue(std::move(ids));
}

std::vector<int> ReadRoomIds(const JsonNode& node) {
  std::vector<int> rooms;
  for (const JsonNode& id : node.Items()) rooms.push_back(id.Int(0, kMaxId));
  return rooms;
}

JsonValue RoomToJson(const LayoutRoom& room) {
  JsonObject row;
  JsonArray polygon;
  for (const Eigen::Vector2d& corner : room.polygon_m) {
    polygon.emplace_back(corner.x());
    polygon.emplace_back(corner.y());
  }
  JsonArray guessed;
  for (const bool guess : room.guessed) guessed.emplace_back(guess);
  row.emplace("polygon_m", std::move(polygon));
  row.emplace("guessed", std::move(guessed));
  row.emplace("area_m2", AreaOf(room.polygon_m));
  row.emplace("floor_m", room.floor_m);
  row.emplace("ceiling_m", room.ceiling_m > room.floor_m ? JsonValue(room.ceiling_m) : JsonValue());
  row.emplace("seen_share", room.seen_share);
  row.emplace("confidence", room.confidence);
  if (!room.note.empty()) row.emplace("note", room.note);
  return JsonValue(std::move(row));
}

LayoutRoom ReadRoom(const JsonNode& row) {
  LayoutRoom room;
  const std::vector<JsonNode> numbers = row["polygon_m"].Items();
  if (numbers.size() < 6 || numbers.size() % 2 != 0)
    row["polygon_m"].Fail("must be x, y of three corners or more");
  for (std::size_t n = 0; n + 1 < numbers.size(); n += 2)
    room.polygon_m.emplace_back(ReadHeight(numbers[n]), ReadHeight(numbers[n + 1]));
  for (const JsonNode& guess : row["guessed"].Items()) room.guessed.push_back(guess.Bool());
  if (room.guessed.size() != room.polygon_m.size())
    row["guessed"].Fail("must have one value per corner of the polygon");
  room.floor_m = ReadHeight(row["floor_m"]);
  if (const JsonNode ceiling = row.Maybe("ceiling_m"); ceiling.exists()) {
    room.ceiling_m = ReadHeight(ceiling);
    if (room.ceiling_m <= room.floor_m) ceiling.Fail("must be above floor_m");
  }
  room.seen_share = row["seen_share"].Number(0, 1);
  room.confidence = row["confidence"].Number(0, 1);
  if (const JsonNode note = row.Maybe("note"); note.exists()) room.note = note.String();
  return room;
}

JsonValue WallToJson(const LayoutWall& wall) {
  JsonObject row;
  row.emplace("from_m", ToJson(wall.from_m));
  row.emplace("to_m", ToJson(wall.to_m));
  row.emplace("bottom_m", wall.bottom_m);
  row.emplace("top_m", wall.top_m);
  row.emplace("rooms", RoomIds(wall.rooms));
  row.emplace("seen_share", wall.seen_share);
  row.emplace("confidence", wall.confidence);
  row.emplace("offset_sigma_m", wall.offset_sigma_m);
  row.emplace("angle_sigma_rad", wall.angle_sigma_rad);
  return JsonValue(std::move(row));
}

LayoutWall ReadWall(const JsonNode& row) {
  LayoutWall wall;
  wall.from_m = ReadPlace(row["from_m"]);
  wall.to_m = ReadPlace(row["to_m"]);
  wall.bottom_m = ReadHeight(row["bottom_m"]);
  wall.top_m = ReadHeight(row["top_m"]);
  if (wall.top_m < wall.bottom_m) row["top_m"].Fail("must not be below bottom_m");
  wall.rooms = ReadRoomIds(row["rooms"]);
  wall.seen_share = row["seen_share"].Number(0, 1);
  wall.confidence = row["confidence"].Number(0, 1);
  wall.offset_sigma_m = row["offset_sigma_m"].Number(0, kMaxPlace_m);
  wall.angle_sigma_rad = row["angle_sigma_rad"].Number(0, kMaxPlace_m);
  return wall;
}

JsonValue OpeningToJson(const LayoutOpening& opening) {
  JsonObject row;
  row.emplace("wall", opening.wall);
  row.emplace("kind", NameOf(opening.kind));
  row.emplace("from_m", ToJson(opening.from_m));
  row.emplace("to_m", ToJson(opening.to_m));
  row.emplace("bottom_m", opening.bottom_m);
  row.emplace("top_m", opening.top_m);
  row.emplace("rooms", RoomIds(opening.rooms));
  row.emplace("confidence", opening.confidence);
  if (!opening.note.empty()) row.emplace("note", opening.note);
  return JsonValue(std::move(row));
}

OpeningKind ReadKind(const JsonNode& node) {
  const std::string name = node.String();
  for (const OpeningKind kind : {OpeningKind::kDoor, OpeningKind::kWindow, OpeningKind::kPassage}) {
    if (NameOf(kind) == name) return kind;
  }
  node.Fail("must be door, window or passage");
  return OpeningKind::kDoor;
}

LayoutOpening ReadOpening(const JsonNode& row) {
  LayoutOpening opening;
  opening.wall = row["wall"].Int(0, kMaxId);
  opening.kind = ReadKind(row["kind"]);
  opening.from_m = ReadPlace(row["from_m"]);
  opening.to_m = ReadPlace(row["to_m"]);
  opening.bottom_m = ReadHeight(row["bottom_m"]);
  opening.top_m = ReadHeight(row["top_m"]);
  if (opening.top_m < opening.bottom_m) row["top_m"].Fail("must not be below bottom_m");
  opening.rooms = ReadRoomIds(row["rooms"]);
  opening.confidence = row["confidence"].Number(0, 1);
  if (const JsonNode note = row.Maybe("note"); note.exists()) opening.note = note.String();
  return opening;
}

JsonValue LevelToJson(const LayoutLevel& level) {
  JsonObject row;
  row.emplace("kind", level.kind == LevelKind::kFloor ? "floor" : "ceiling");
  row.emplace("height_m", level.height_m);
  row.emplace("area_m2", level.area_m2);
  return JsonValue(std::move(row));
}

LayoutLevel ReadLevel(const JsonNode& row) {
  LayoutLevel level;
  const std::string kind = row["kind"].String();
  if (kind != "floor" && kind != "ceiling") row["kind"].Fail("must be floor or ceiling");
  level.kind = kind == "ceiling" ? LevelKind::kCeiling : LevelKind::kFloor;
  level.height_m = ReadHeight(row["height_m"]);
  level.area_m2 = row["area_m2"].Number(0, kMaxArea_m2);
  return level;
}

JsonValue SlantedToJson(const SlantedPlane& slanted) {
  JsonObject row;
  row.emplace("plane", artifact::ToJson(slanted.plane));
  row.emplace("centre_m", artifact::ToJson(slanted.centre_m));
  row.emplace("area_m2", slanted.area_m2);
  return JsonValue(std::move(row));
}

SlantedPlane ReadSlanted(const JsonNode& row) {
  return {
      ReadPlane(row["plane"]), ReadVector3(row["centre_m"]), row["area_m2"].Number(0, kMaxArea_m2)};
}

template <typename Value, typename Read>
std::vector<Value> ReadAll(const JsonNode& node, const Read& read) {
  std::vector<Value> values;
  for (const JsonNode& row : node.Items()) values.push_back(read(row));
  return values;
}

void CheckRooms(const JsonNode& node, const std::vector<int>& rooms, std::size_t num_rooms) {
  for (const int room : rooms) {
    if (static_cast<std::size_t>(room) >= num_rooms) node.Fail("names a room that is not there");
  }
}

void CheckIds(const JsonNode& root, const Layout& layout) {
  for (const LayoutWall& wall : layout.walls)
    CheckRooms(root["walls"], wall.rooms, layout.rooms.size());
  for (const LayoutOpening& opening : layout.openings) {
    CheckRooms(root["openings"], opening.rooms, layout.rooms.size());
    if (static_cast<std::size_t>(opening.wall) >= layout.walls.size())
      root["openings"].Fail("names a wall that is not there");
  }
}

}  // namespace

Result<std::string> EncodeLayout(const Layout& layout, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  document.emplace("rooms", RowsOf(layout.rooms, RoomToJson));
  document.emplace("walls", RowsOf(layout.walls, WallToJson));
  document.emplace("openings", RowsOf(layout.openings, OpeningToJson));
  document.emplace("levels", RowsOf(layout.levels, LevelToJson));
  document.emplace("slanted", RowsOf(layout.slanted, SlantedToJson));
  document.emplace("level_from_tracking", artifact::ToJson(layout.level_from_tracking));
  JsonArray notes;
  for (const std::string& note : layout.notes) notes.emplace_back(note);
  document.emplace("notes", std::move(notes));
  return DumpJson(std::move(document), name);
}

Result<Layout> DecodeLayout(TextSource text, std::string_view name) {
  JsonReader reader(std::move(text), name, kFormat, kVersion);
  const JsonNode root = reader.root();
  Layout layout;
  layout.rooms = ReadAll<LayoutRoom>(root["rooms"], ReadRoom);
  layout.walls = ReadAll<LayoutWall>(root["walls"], ReadWall);
  layout.openings = ReadAll<LayoutOpening>(root["openings"], ReadOpening);
  layout.levels = ReadAll<LayoutLevel>(root["levels"], ReadLevel);
  layout.slanted = ReadAll<SlantedPlane>(root["slanted"], ReadSlanted);
  layout.level_from_tracking = ReadPose(root["level_from_tracking"]);
  for (const JsonNode& note : root["notes"].Items()) layout.notes.push_back(note.String());
  CheckIds(root, layout);
  return reader.Finish(std::move(layout));
}

}  // namespace deepslam::artifact
