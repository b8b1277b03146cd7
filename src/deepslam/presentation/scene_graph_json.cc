#include "deepslam/presentation/scene_graph_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/core/angles.h"

namespace deepslam::presentation {
namespace {

constexpr int kVersion = 1;  // of the format; raised when fields change (scene_graph.schema.json)
constexpr std::array<std::string_view, 6> kPredicates = {
    "against_wall", "hangs_on", "in_front_of", "in_room", "next_to", "stands_on"};

using Json = nlohmann::json;  // keys sorted

Json Numbers(const Eigen::Vector2d& p) { return Json::array({p.x(), p.y()}); }
Json Numbers(const Eigen::Vector3d& p) { return Json::array({p.x(), p.y(), p.z()}); }
Json Numbers(const Eigen::Quaterniond& q) { return Json::array({q.x(), q.y(), q.z(), q.w()}); }

bool Holds(const std::vector<int>& ids, std::size_t id) {
  return std::find(ids.begin(), ids.end(), static_cast<int>(id)) != ids.end();
}

Json RoomJson(const SceneGraph& graph, std::size_t id) {
  const CompactRoom& room = graph.layout.rooms[id];
  Json polygon = Json::array();
  for (const Eigen::Vector2d& corner : room.polygon_m) polygon.emplace_back(Numbers(corner));
  Json walls = Json::array();
  Json openings = Json::array();
  Json objects = Json::array();
  for (std::size_t n = 0; n < graph.layout.walls.size(); ++n) {
    if (Holds(graph.layout.walls[n].rooms, id)) walls.emplace_back(static_cast<int>(n));
  }
  for (std::size_t n = 0; n < graph.layout.openings.size(); ++n) {
    const auto wall = static_cast<std::size_t>(graph.layout.openings[n].wall);
    if (Holds(graph.layout.walls[wall].rooms, id)) openings.emplace_back(static_cast<int>(n));
  }
  for (const GraphObject& object : graph.objects) {
    if (object.room == static_cast<int>(id)) objects.emplace_back(object.id.value);
  }
  return {{"id", static_cast<int>(id)},
          {"name", fmt::format("room_{:02}", id)},
          {"polygon_m", std::move(polygon)},
          {"floor_m", room.floor_m},
          {"ceiling_m", room.ceiling_m ? Json(*room.ceiling_m) : Json()},
          {"area_m2", std::max(0.0, AreaOf(room.polygon_m))},
          {"walls", std::move(walls)},
          {"openings", std::move(openings)},
          {"objects", std::move(objects)}};
}

Json WallJson(const CompactWall& wall, std::size_t id) {
  return {{"id", static_cast<int>(id)},
          {"name", fmt::format("wall_{:02}", id)},
          {"rooms", wall.rooms},
          {"from_m", Numbers(wall.from_m)},
          {"to_m", Numbers(wall.to_m)},
          {"bottom_m", wall.bottom_m},
          {"top_m", wall.top_m},
          {"seen_share", wall.seen_share},
          {"confidence", wall.confidence}};
}

Json OpeningJson(const CompactLayout& layout, std::size_t id) {
  const CompactOpening& opening = layout.openings[id];
  const std::string_view kind = NameOf(opening.kind);
  return {{"id", static_cast<int>(id)},
          {"name", fmt::format("{}_{:02}", kind, id)},
          {"kind", kind},
          {"wall", opening.wall},
          {"rooms", layout.walls[static_cast<std::size_t>(opening.wall)].rooms},
          {"from_m", Numbers(opening.from_m)},
          {"to_m", Numbers(opening.to_m)},
          {"bottom_m", opening.bottom_m},
          {"top_m", opening.top_m},
          {"confidence", opening.confidence}};
}

Json LabelsJson(const CommonLabels& labels) {
  Json json = Json::object();
  const auto add = [&](const char* set, const std::optional<ClassLabel>& label) {
    if (label) json[set] = {{"id", label->id}, {"name", label->name}};
  };
  add("coco", labels.coco);
  add("nyu40", labels.nyu40);
  add("scannet200", labels.scannet200);
  return json;
}

Json ObjectJson(const GraphObject& object) {
  const Pose3& pose = object.world_from_object;
  const Eigen::Vector3d front = pose.rotation * Eigen::Vector3d::UnitX();
  return {
      {"id", object.id.value},
      {"name", object.name},
      {"class", object.class_name},
      {"labels", LabelsJson(object.labels)},
      {"confidence", object.confidence},
      {"source", NameOf(object.source)},
      {"world_from_object",
       {{"rotation_xyzw", Numbers(pose.rotation)}, {"translation_m", Numbers(pose.translation_m)}}},
      {"centre_m", Numbers(object.centre_world)},
      {"size_m", Numbers(object.size_m)},
      {"oriented_box",
       Json{{"centre_m", Numbers(object.centre_world)},
            {"size_m", Numbers(object.size_m)},
            {"rotation_xyzw", Numbers(pose.rotation)}}},
      {"axis_aligned_box",
       Json{{"min_m", Numbers(object.box_world.min)}, {"max_m", Numbers(object.box_world.max)}}},
      {"heading_deg", std::atan2(front.y(), front.x()) * kDegPerRad},
      {"has_front", object.has_front},
      {"has_mesh", object.has_mesh},
      {"volume_m3", object.volume_m3},
      {"room", object.room ? Json(*object.room) : Json()},
      {"credit", object.credit},
      {"note", object.note}};
}

Json RelationJson(const GraphRelation& relation) {
  Json json = {{"subject", relation.subject},
               {"predicate", kPredicates[static_cast<std::size_t>(relation.predicate)]},
               {"object", relation.object}};
  if (relation.distance_m) json["distance_m"] = *relation.distance_m;
  return json;
}

// The elements of a list, each as `to_json` has it.
template <typename ToJson>
Json Listed(std::size_t count, const ToJson& to_json) {
  Json array = Json::array();
  for (std::size_t n = 0; n < count; ++n) array.push_back(to_json(n));
  return array;
}

bool IsFinite(const Json& json) {
  if (json.is_number_float()) return std::isfinite(json.get<double>());
  return std::all_of(json.begin(), json.end(), [&](const Json& element) {
    return !json.is_structured() || IsFinite(element);
  });
}

}  // namespace

Result<std::string> EncodeSceneGraph(const SceneGraph& graph, std::string_view name) {
  const CompactLayout& layout = graph.layout;
  const Json json = {
      {"format", "deepslam/scene_graph"},
      {"version", kVersion},
      {"tool_version", graph.tool_version},
      {"capture_name", graph.capture_name},
      {"capture_hash", graph.capture_hash},
      {"verdict", NameOf(graph.verdict.verdict)},
      {"reasons", graph.verdict.reasons},
      {"rooms", Listed(layout.rooms.size(), [&](std::size_t n) { return RoomJson(graph, n); })},
      {"walls",
       Listed(layout.walls.size(), [&](std::size_t n) { return WallJson(layout.walls[n], n); })},
      {"openings",
       Listed(layout.openings.size(), [&](std::size_t n) { return OpeningJson(layout, n); })},
      {"objects",
       Listed(graph.objects.size(), [&](std::size_t n) { return ObjectJson(graph.objects[n]); })},
      {"relations", Listed(graph.relations.size(), [&](std::size_t n) {
         return RelationJson(graph.relations[n]);
       })}};
  if (!IsFinite(json))
    return InvalidInput(fmt::format("{}: holds a number that is not finite", name));
  // What is no UTF-8 becomes U+FFFD.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace deepslam::presentation
