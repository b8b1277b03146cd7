#include "deepslam/artifact/objects_json.h"

#include <utility>

#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/objects", 1};

// One line per view: [view, frame, num_points, surface, num_seen, coverage, violation].
void Describe(JsonVisitor& visitor, ViewAgreement& view) {
  visitor.Columns(view.view,
                  view.frame,
                  view.num_points,
                  view.surface,
                  view.num_seen,
                  view.coverage,
                  view.violation);
}

void Describe(JsonVisitor& visitor, CandidateScore& score) {
  visitor.Field("candidate", score.candidate);
  visitor.Field("score", score.score);
  visitor.Field("surface_share", score.surface_share);
  visitor.Field("coverage_share", score.coverage_share);
  visitor.Field("free_violation", score.free_violation);
  visitor.Field("num_views", score.num_views);
  visitor.Field("seen_share", score.seen_share);
  visitor.Maybe("reached_share", score.reached_share);
  visitor.Maybe("front_blocked", score.front_blocked);
  visitor.Field("note", score.note);
  visitor.Field("views", score.views);
}

void Describe(JsonVisitor& visitor, Replacement& replacement) {
  visitor.Maybe("frame", replacement.frame);
  visitor.Maybe("candidate", replacement.candidate);
  visitor.Field("score", replacement.score);
}

void Describe(JsonVisitor& visitor, MapObject& object) {
  visitor.Field("id", object.id);
  visitor.Field("class", object.class_name);
  visitor.Maybe("class_votes", object.class_votes);
  visitor.Maybe("chosen", object.chosen);
  visitor.Field("source", object.source);
  visitor.Field("model", object.model);
  if (!object.model.empty() && !IsModelKey(object.model)) visitor.Fail("model", "is no model key");
  visitor.Field("library_id", object.library_id);
  visitor.Field("credit", object.credit);
  visitor.Field("scale_m", object.scale_m, kSizeM);
  visitor.Field("world_from_object", object.world_from_object);
  visitor.Field("confidence", object.confidence);
  visitor.Field("note", object.note);
  visitor.Field("views", object.views);
  visitor.Field("scores", object.scores);
  visitor.Field("history", object.history);
  visitor.Field("merged", object.merged);
}

void Describe(JsonVisitor& visitor, ObjectMap& map) {
  visitor.Table("objects", map.objects);
  visitor.Field("dropped", map.dropped);
}

Result<std::string> EncodeObjectMap(const ObjectMap& map, std::string_view name) {
  return EncodeDocument(kFormat, map, name);
}

Result<ObjectMap> DecodeObjectMap(TextSource text, std::string_view name) {
  return DecodeDocument<ObjectMap>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
