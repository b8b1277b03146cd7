#include "deepslam/artifact/loops_json.h"

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/loops";
constexpr int kVersion = 3;
constexpr int kMostCorners = 1000000;

JsonValue MergesToJson(const std::vector<ObjectMerge>& merges) {
  JsonArray rows;
  for (const ObjectMerge& merge : merges) {
    JsonObject row;
    row.emplace("kept", ToJson(merge.kept));
    row.emplace("merged", ToJson(merge.merged));
    rows.emplace_back(std::move(row));
  }
  return JsonValue(std::move(rows));
}

std::vector<ObjectMerge> ReadMerges(const JsonNode& node) {
  std::vector<ObjectMerge> merges;
  for (const JsonNode& row : node.Items()) {
    merges.push_back({ReadId<ObjectId>(row["kept"]), ReadId<ObjectId>(row["merged"])});
  }
  return merges;
}

JsonValue ConstellationToJson(const Constellation& constellation) {
  JsonObject row;
  row.emplace("pairs", MergesToJson(constellation.pairs));
  row.emplace("old_world_from_new_world", ToJson(constellation.old_world_from_new_world));
  row.emplace("position_error_m", constellation.position_error_m);
  row.emplace("accepted", constellation.accepted);
  row.emplace("reason", constellation.reason);
  return JsonValue(std::move(row));
}

JsonValue AppearanceToJson(const AppearanceLoop& loop) {
  JsonObject row;
  row.emplace("old_keyframe", ToJson(loop.old_keyframe));
  row.emplace("new_keyframe", ToJson(loop.new_keyframe));
  row.emplace("old_from_new", ToJson(loop.old_from_new));
  row.emplace("num_inliers", loop.num_inliers);
  row.emplace("num_support", loop.num_support);
  row.emplace("agreement", loop.agreement);
  row.emplace("accepted", loop.accepted);
  row.emplace("reason", loop.reason);
  return JsonValue(std::move(row));
}

AppearanceLoop ReadAppearance(const JsonNode& row) {
  AppearanceLoop loop;
  loop.old_keyframe = ReadId<FrameIdx>(row["old_keyframe"]);
  loop.new_keyframe = ReadId<FrameIdx>(row["new_keyframe"]);
  loop.old_from_new = ReadPose(row["old_from_new"]);
  loop.num_inliers = row["num_inliers"].Int(0, kMostCorners);
  loop.num_support = row["num_support"].Int(0, kMostCorners);
  loop.agreement = row["agreement"].Number();
  loop.accepted = row["accepted"].Bool();
  loop.reason = row["reason"].String();
  return loop;
}

JsonValue EdgeToJson(const RelativePose& edge) {
  JsonObject row;
  row.emplace("i", ToJson(edge.i));
  row.emplace("j", ToJson(edge.j));
  row.emplace("i_from_j", ToJson(edge.i_from_j));
  row.emplace("information", ToJson(edge.information));
  row.emplace("composed", edge.composed);
  return JsonValue(std::move(row));
}

JsonValue VisitToJson(const PartedVisit& visit) {
  JsonObject row;
  row.emplace("visit", ToJson(visit.visit));
  row.emplace("object", ToJson(visit.object));
  row.emplace("first", ToJson(visit.first));
  row.emplace("last", ToJson(visit.last));
  return JsonValue(std::move(row));
}

}  // namespace

Result<std::string> EncodeLoops(const Loops& loops, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  JsonArray constellations;
  for (const Constellation& constellation : loops.constellations) {
    constellations.push_back(ConstellationToJson(constellation));
  }
  JsonArray edges;
  for (const RelativePose& edge : loops.edges) edges.push_back(EdgeToJson(edge));
  document.emplace("constellations", std::move(constellations));
  document.emplace("merges", MergesToJson(loops.merges));
  document.emplace("edges", std::move(edges));
  JsonArray appearance;
  for (const AppearanceLoop& loop : loops.appearance) appearance.push_back(AppearanceToJson(loop));
  document.emplace("appearance", std::move(appearance));
  JsonArray visits;
  for (const PartedVisit& visit : loops.visits) visits.push_back(VisitToJson(visit));
  document.emplace("visits", std::move(visits));
  return DumpJson(std::move(document), name);
}

Result<Loops> DecodeLoops(std::string_view text, std::string_view name) {
  JsonReader reader(text, name, kFormat, kVersion);
  const JsonNode root = reader.root();
  Loops loops;
  for (const JsonNode& row : root["constellations"].Items()) {
    Constellation constellation;
    constellation.pairs = ReadMerges(row["pairs"]);
    constellation.old_world_from_new_world = ReadPose(row["old_world_from_new_world"]);
    constellation.position_error_m = row["position_error_m"].Number();
    constellation.accepted = row["accepted"].Bool();
    constellation.reason = row["reason"].String();
    loops.constellations.push_back(std::move(constellation));
  }
  loops.merges = ReadMerges(root["merges"]);
  for (const JsonNode& row : root["edges"].Items()) {
    RelativePose edge;
    edge.i = ReadId<FrameIdx>(row["i"]);
    edge.j = ReadId<FrameIdx>(row["j"]);
    edge.i_from_j = ReadPose(row["i_from_j"]);
    edge.information = ReadMatrix6(row["information"]);
    edge.composed = row["composed"].Bool();
    loops.edges.push_back(edge);
  }
  for (const JsonNode& row : root["appearance"].Items())
    loops.appearance.push_back(ReadAppearance(row));
  for (const JsonNode& row : root["visits"].Items()) {
    loops.visits.push_back({ReadId<ObjectId>(row["visit"]),
                            ReadId<ObjectId>(row["object"]),
                            ReadId<FrameIdx>(row["first"]),
                            ReadId<FrameIdx>(row["last"])});
  }
  return reader.Finish(std::move(loops));
}

}  // namespace deepslam::artifact
