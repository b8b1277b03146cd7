#include "deepslam/artifact/loops_json.h"

#include <utility>

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

Constellation ReadConstellation(const JsonNode& row) {
  Constellation constellation;
  constellation.pairs = ReadMerges(row["pairs"]);
  constellation.old_world_from_new_world = ReadPose(row["old_world_from_new_world"]);
  constellation.position_error_m = row["position_error_m"].Number();
  constellation.accepted = row["accepted"].Bool();
  constellation.reason = row["reason"].String();
  return constellation;
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
  row.emplace("information", ToJson(edge.information.Full()));
  row.emplace("composed", edge.composed);
  return JsonValue(std::move(row));
}

RelativePose ReadEdge(const JsonNode& row) {
  RelativePose edge;
  edge.i = ReadId<FrameIdx>(row["i"]);
  edge.j = ReadId<FrameIdx>(row["j"]);
  edge.i_from_j = ReadPose(row["i_from_j"]);
  edge.information = ReadMatrix6(row["information"]);
  edge.composed = row["composed"].Bool();
  return edge;
}

JsonValue VisitToJson(const PartedVisit& visit) {
  JsonObject row;
  row.emplace("visit", ToJson(visit.visit));
  row.emplace("object", ToJson(visit.object));
  row.emplace("first", ToJson(visit.first));
  row.emplace("last", ToJson(visit.last));
  return JsonValue(std::move(row));
}

PartedVisit ReadVisit(const JsonNode& row) {
  return {ReadId<ObjectId>(row["visit"]),
          ReadId<ObjectId>(row["object"]),
          ReadId<FrameIdx>(row["first"]),
          ReadId<FrameIdx>(row["last"])};
}

}  // namespace

Result<std::string> EncodeLoops(const Loops& loops, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  document.emplace("constellations", RowsOf(loops.constellations, ConstellationToJson));
  document.emplace("merges", MergesToJson(loops.merges));
  document.emplace("edges", RowsOf(loops.edges, EdgeToJson));
  document.emplace("appearance", RowsOf(loops.appearance, AppearanceToJson));
  document.emplace("visits", RowsOf(loops.visits, VisitToJson));
  return DumpJson(std::move(document), name);
}

Result<Loops> DecodeLoops(TextSource text, std::string_view name) {
  Loops loops;
  JsonReader reader(std::move(text),
                    name,
                    kFormat,
                    kVersion,
                    {{"constellations", AppendRows(loops.constellations, ReadConstellation)},
                     {"edges", AppendRows(loops.edges, ReadEdge)},
                     {"appearance", AppendRows(loops.appearance, ReadAppearance)},
                     {"visits", AppendRows(loops.visits, ReadVisit)}});
  loops.merges = ReadMerges(reader.root()["merges"]);
  return reader.Finish(std::move(loops));
}

}  // namespace deepslam::artifact
