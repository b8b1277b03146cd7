#include "deepslam/artifact/map_json.h"

#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/layout_json.h"
#include "deepslam/artifact/scene_json.h"
#include "deepslam/core/base64.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/map", 5, 4};  // 4 has no layout
constexpr double kMinStretch = 0.01;  // of a library model, per axis; no fit of a thing goes as far
constexpr double kMaxStretch = 100;   // the same bound the other way round
constexpr Range kLatent{-1e6, 1e6};
constexpr std::size_t kMaxOutlinePoints = 100'000;  // files of more are refused
constexpr Range kPlaceM{-1e5, 1e5};

namespace {

void DescribeVoxels(JsonVisitor& visitor, std::string& code) {
  std::string base64 = EncodeBase64(code);
  if (!visitor.Maybe("voxels_base64", base64, !code.empty()) || !visitor.reading()) return;
  Result<std::string> bytes = DecodeBase64(base64);
  if (bytes.ok()) {
    code = std::move(bytes).value();
  } else {
    visitor.Fail("voxels_base64", ": " + bytes.error().message);
  }
}

}  // namespace

void Describe(JsonVisitor& visitor, CompactShape& shape) {
  visitor.Maybe("latents", shape.latents, !shape.latents.empty(), kLatent);
  if (visitor.Maybe("library_id", shape.library_id, !shape.library_id.empty())) {
    visitor.Field("library_checksum", shape.library_checksum);
    visitor.Maybe("stretch", shape.stretch, shape.stretch != Eigen::Vector3d::Ones());
    if (!(shape.stretch.array() >= kMinStretch && shape.stretch.array() <= kMaxStretch).all())
      visitor.Fail("stretch", fmt::format("must lie in [{}, {}]", kMinStretch, kMaxStretch));
    visitor.Maybe("voxels_checksum", shape.voxels_checksum, !shape.voxels_checksum.empty());
  }
  DescribeVoxels(visitor, shape.voxel_code);
}

void Describe(JsonVisitor& visitor, CompactObject& object) {
  visitor.Field("id", object.id);
  visitor.Field("name", object.name);
  visitor.Field("class", object.class_name);
  visitor.Field("confidence", object.confidence, kShare);
  visitor.Field("source", object.source);
  visitor.Field("world_from_object", object.world_from_object);
  visitor.Field("scale_m", object.scale_m, kSizeM);
  visitor.Field("size_m", object.size_m);
  visitor.Field("credit", object.credit);
  visitor.Field("note", object.note);
  visitor.Field("shape", object.shape);
  visitor.Maybe("room", object.room, object.room.has_value());
  visitor.Maybe("stands_on", object.stands_on, !object.stands_on.empty());
  visitor.Maybe("against_wall", object.against_wall, object.against_wall.has_value());
}

void Describe(JsonVisitor& visitor, CompactRoom& room) {
  DescribePolygon(visitor, room.polygon_m);
  visitor.Field("floor_m", room.floor_m, kPlanPlace_m);
  visitor.Field("ceiling_m", room.ceiling_m);
  if (!visitor.reading() || !room.ceiling_m) return;
  if (!(*room.ceiling_m > room.floor_m && *room.ceiling_m < kPlanPlace_m.max))
    visitor.Fail("ceiling_m", "must be above floor_m");
}

void Describe(JsonVisitor& visitor, CompactWall& wall) {
  visitor.Field("rooms", wall.rooms);
  visitor.Field("from_m", wall.from_m);
  visitor.Field("to_m", wall.to_m);
  DescribeHeights(visitor, wall);
  visitor.Field("seen_share", wall.seen_share, kShare);
  visitor.Field("confidence", wall.confidence, kShare);
}

void Describe(JsonVisitor& visitor, CompactOpening& opening) {
  visitor.Field("wall", opening.wall);
  visitor.Field("kind", opening.kind);
  visitor.Field("from_m", opening.from_m);
  visitor.Field("to_m", opening.to_m);
  DescribeHeights(visitor, opening);
  visitor.Field("confidence", opening.confidence, kShare);
}

// Rows that name their own place in the list, so that a reader may pick one out.
template <typename Row>
struct NumberedRow {
  int id = 0;
  Row row;
};
template <typename Row>
void Describe(JsonVisitor& visitor, NumberedRow<Row>& numbered) {
  visitor.Field("id", numbered.id);
  Describe(visitor, numbered.row);
}

template <typename Row>
void DescribeNumbered(JsonVisitor& visitor, std::string_view name, std::vector<Row>& rows) {
  std::vector<NumberedRow<Row>> numbered;
  for (std::size_t n = 0; n < rows.size(); ++n) numbered.push_back({static_cast<int>(n), rows[n]});
  visitor.Field(name, numbered);
  if (!visitor.reading()) return;
  rows.clear();
  for (NumberedRow<Row>& row : numbered) {
    if (row.id != static_cast<int>(rows.size()))
      visitor.Fail(name, "must have ids from 0, in their order");
    rows.push_back(std::move(row.row));
  }
}

void Describe(JsonVisitor& visitor, CompactLayout& layout) {
  DescribeNumbered(visitor, "rooms", layout.rooms);
  DescribeNumbered(visitor, "walls", layout.walls);
  DescribeNumbered(visitor, "openings", layout.openings);
  if (!visitor.reading()) return;
  for (const CompactWall& wall : layout.walls)
    CheckRooms(visitor, "walls", wall.rooms, layout.rooms.size());
  for (const CompactOpening& opening : layout.openings) {
    if (static_cast<std::size_t>(opening.wall) >= layout.walls.size())
      visitor.Fail("openings", "names a wall that is not there");
  }
}

namespace {

// x and y in turn: an array of its own for every point would cost as much as its numbers.
void DescribeOutline(JsonVisitor& visitor, std::vector<Eigen::Vector2d>& outline_m) {
  std::vector<double> numbers;
  for (const Eigen::Vector2d& p : outline_m) numbers.insert(numbers.end(), {p.x(), p.y()});
  visitor.Field("ground_outline_m", numbers, kPlaceM);
  if (!visitor.reading()) return;
  if (numbers.size() > 2 * kMaxOutlinePoints) {
    return visitor.Fail("ground_outline_m",
                        fmt::format("has more than {} points", kMaxOutlinePoints));
  }
  if (numbers.size() % 2 != 0) return visitor.Fail("ground_outline_m", "must hold x and y in turn");
  for (std::size_t n = 0; n < numbers.size(); n += 2)
    outline_m.emplace_back(numbers[n], numbers[n + 1]);
}

}  // namespace

void Describe(JsonVisitor& visitor, Verdict& verdict) { visitor.Choice(verdict, kVerdictNames); }

// Of objects in the layout.
void CheckPlaces(JsonVisitor& visitor, const CompactMap& map) {
  const std::size_t num_rooms = map.layout ? map.layout->rooms.size() : 0;
  const std::size_t num_walls = map.layout ? map.layout->walls.size() : 0;
  for (const CompactObject& object : map.objects) {
    if (object.room && static_cast<std::size_t>(*object.room) >= num_rooms)
      visitor.Fail("objects", fmt::format(": {} is in a room that is not there", object.name));
    if (object.against_wall && static_cast<std::size_t>(*object.against_wall) >= num_walls)
      visitor.Fail("objects", fmt::format(": {} is at a wall that is not there", object.name));
  }
}

void Describe(JsonVisitor& visitor, CompactMap& map) {
  visitor.Field("tool_version", map.tool_version);
  visitor.Field("capture_name", map.capture_name);
  visitor.Field("capture_hash", map.capture_hash);
  visitor.Maybe("ground_world", map.ground_world);
  DescribeOutline(visitor, map.ground_outline_m);
  visitor.Field("class_colours", map.class_colours);
  visitor.Field("mesh_options", map.mesh_options);
  visitor.Field("verdict", map.verdict);
  visitor.Field("reasons", map.reasons);
  visitor.Maybe("layout", map.layout, map.layout.has_value());
  visitor.Field("objects", map.objects);
  if (visitor.reading()) CheckPlaces(visitor, map);
}

Result<std::string> EncodeMap(const CompactMap& map, std::string_view name) {
  return EncodeDocument(kFormat, map, name);
}

Result<CompactMap> DecodeMap(TextSource text, std::string_view name) {
  return DecodeDocument<CompactMap>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
