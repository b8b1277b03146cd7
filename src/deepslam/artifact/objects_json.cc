#include "deepslam/artifact/objects_json.h"

#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/objects";
constexpr int kVersion = 1;

// One line per view: [view, frame, num_points, surface, num_seen, coverage, violation].
JsonValue AgreementToJson(const ViewAgreement& view) {
  return JsonArray{ToJson(view.view),
                   ToJson(view.frame),
                   view.num_points,
                   view.surface,
                   view.num_seen,
                   view.coverage,
                   view.violation};
}

ViewAgreement ReadAgreement(const JsonNode& node) {
  const std::vector<JsonNode> n = node.Items(7);
  ViewAgreement view;
  view.view = ReadId<DetectionId>(n[0]);
  view.frame = ReadId<FrameIdx>(n[1]);
  view.num_points = n[2].Int(0, kMaxId);
  view.surface = n[3].Number();
  view.num_seen = n[4].Int(0, kMaxId);
  view.coverage = n[5].Number();
  view.violation = n[6].Number();
  return view;
}

JsonValue ScoreToJson(const CandidateScore& score) {
  JsonObject row;
  row.emplace("candidate", ToJson(score.candidate));
  row.emplace("score", score.score);
  row.emplace("surface_share", score.surface_share);
  row.emplace("coverage_share", score.coverage_share);
  row.emplace("free_violation", score.free_violation);
  row.emplace("num_views", score.num_views);
  row.emplace("seen_share", score.seen_share);
  row.emplace("reached_share", score.reached_share);
  row.emplace("note", score.note);
  JsonArray views;
  for (const ViewAgreement& view : score.views) views.push_back(AgreementToJson(view));
  row.emplace("views", std::move(views));
  return JsonValue(std::move(row));
}

CandidateScore ReadScore(const JsonNode& row) {
  CandidateScore score;
  score.candidate = ReadId<CandidateId>(row["candidate"]);
  score.score = row["score"].Number();
  score.surface_share = row["surface_share"].Number();
  score.coverage_share = row["coverage_share"].Number();
  score.free_violation = row["free_violation"].Number();
  score.num_views = row["num_views"].Int(0, kMaxId);
  score.seen_share = row["seen_share"].Number();
  if (const JsonNode reached = row.Maybe("reached_share"); reached.exists())
    score.reached_share = reached.Number();
  score.note = row["note"].String();
  for (const JsonNode& view : row["views"].Items()) score.views.push_back(ReadAgreement(view));
  return score;
}

JsonValue ReplacementToJson(const Replacement& replacement) {
  JsonObject row;
  row.emplace("frame", ToJson(replacement.frame));
  row.emplace("candidate", ToJson(replacement.candidate));
  row.emplace("score", replacement.score);
  return JsonValue(std::move(row));
}

JsonValue ObjectToJson(const MapObject& object) {
  JsonArray views;
  for (const ViewRegistration& view : object.views) views.push_back(ToJson(view));
  JsonArray scores;
  for (const CandidateScore& score : object.scores) scores.push_back(ScoreToJson(score));
  JsonArray history;
  for (const Replacement& replacement : object.history)
    history.push_back(ReplacementToJson(replacement));
  JsonArray merged;
  for (const ObjectId id : object.merged) merged.push_back(ToJson(id));
  JsonObject row;
  row.emplace("id", ToJson(object.id));
  row.emplace("class", object.class_name);
  row.emplace("chosen", ToJson(object.chosen));
  row.emplace("source", NameOf(object.source));
  row.emplace("model", object.model);
  row.emplace("library_id", object.library_id);
  row.emplace("credit", object.credit);
  row.emplace("scale_m", object.scale_m);
  row.emplace("world_from_object", ToJson(object.world_from_object));
  row.emplace("confidence", object.confidence);
  row.emplace("note", object.note);
  row.emplace("views", std::move(views));
  row.emplace("scores", std::move(scores));
  row.emplace("history", std::move(history));
  row.emplace("merged", std::move(merged));
  return JsonValue(std::move(row));
}

MapObject ReadObject(const JsonNode& row) {
  MapObject object;
  object.id = ReadId<ObjectId>(row["id"]);
  object.class_name = row["class"].String();
  object.chosen = ReadId<CandidateId>(row.Maybe("chosen"));
  object.source = ReadCandidateSource(row["source"]);
  object.model = row["model"].String();
  if (!object.model.empty() && !IsModelKey(object.model)) row["model"].Fail("is no model key");
  object.library_id = row["library_id"].String();
  object.credit = row["credit"].String();
  object.scale_m = row["scale_m"].Number(0, 1e3);
  object.world_from_object = ReadPose(row["world_from_object"]);
  object.confidence = row["confidence"].Number();
  object.note = row["note"].String();
  for (const JsonNode& node : row["views"].Items())
    object.views.push_back(ReadViewRegistration(node));
  for (const JsonNode& node : row["scores"].Items()) object.scores.push_back(ReadScore(node));
  for (const JsonNode& node : row["history"].Items()) {
    object.history.push_back({ReadId<FrameIdx>(node.Maybe("frame")),
                              ReadId<CandidateId>(node.Maybe("candidate")),
                              node["score"].Number()});
  }
  for (const JsonNode& node : row["merged"].Items())
    object.merged.push_back(ReadId<ObjectId>(node));
  return object;
}

}  // namespace

Result<std::string> EncodeObjectMap(const ObjectMap& map, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  JsonArray dropped;
  for (const std::string& line : map.dropped) dropped.emplace_back(line);
  document.emplace("objects", RowsOf(map.objects, ObjectToJson));
  document.emplace("dropped", std::move(dropped));
  return DumpJson(std::move(document), name);
}

Result<ObjectMap> DecodeObjectMap(TextSource text, std::string_view name) {
  ObjectMap map;
  JsonReader reader(
      std::move(text), name, kFormat, kVersion, {{"objects", AppendRows(map.objects, ReadObject)}});
  for (const JsonNode& line : reader.root()["dropped"].Items())
    map.dropped.push_back(line.String());
  return reader.Finish(std::move(map));
}

}  // namespace deepslam::artifact
