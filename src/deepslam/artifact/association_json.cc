#include "deepslam/artifact/association_json.h"

#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/tracks";
constexpr int kVersion = 1;

JsonValue TrackToJson(const ObjectTrack& track) {
  JsonArray members;
  for (const TrackMember& member : track.members) {
    JsonObject row;
    row.emplace("detection", ToJson(member.detection));
    row.emplace("frame", ToJson(member.frame));
    row.emplace("num_votes", member.num_votes);
    row.emplace("dissimilarity_m", member.dissimilarity_m);
    row.emplace("how", member.how);
    members.emplace_back(std::move(row));
  }
  JsonObject row;
  row.emplace("id", ToJson(track.id));
  row.emplace("class", track.class_name);
  row.emplace("reason", track.reason);
  row.emplace("members", std::move(members));
  return JsonValue(std::move(row));
}

ObjectTrack ReadTrack(const JsonNode& row) {
  ObjectTrack track;
  track.id = ReadId<ObjectId>(row["id"]);
  track.class_name = row["class"].String();
  track.reason = row["reason"].String();
  for (const JsonNode& node : row["members"].Items()) {
    TrackMember member;
    member.detection = ReadId<DetectionId>(node["detection"]);
    member.frame = ReadId<FrameIdx>(node["frame"]);
    member.num_votes = node["num_votes"].Int(0, kMaxId);
    member.dissimilarity_m = node["dissimilarity_m"].Number();
    member.how = node["how"].String();
    track.members.push_back(std::move(member));
  }
  return track;
}

JsonValue RejectionToJson(const Rejection& rejection) {
  JsonObject row;
  row.emplace("detection", ToJson(rejection.detection));
  row.emplace("frame", ToJson(rejection.frame));
  row.emplace("reason", rejection.reason);
  return JsonValue(std::move(row));
}

Rejection ReadRejection(const JsonNode& row) {
  return {ReadId<DetectionId>(row["detection"]),
          ReadId<FrameIdx>(row["frame"]),
          row["reason"].String()};
}

}  // namespace

Result<std::string> EncodeAssociation(const Association& association, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  document.emplace("tracks", RowsOf(association.tracks, TrackToJson));
  document.emplace("rejections", RowsOf(association.rejections, RejectionToJson));
  return DumpJson(std::move(document), name);
}

Result<Association> DecodeAssociation(TextSource text, std::string_view name) {
  Association association;
  const JsonReader reader(std::move(text),
                          name,
                          kFormat,
                          kVersion,
                          {{"tracks", AppendRows(association.tracks, ReadTrack)},
                           {"rejections", AppendRows(association.rejections, ReadRejection)}});
  return reader.Finish(std::move(association));
}

}  // namespace deepslam::artifact
