#include "deepslam/artifact/loops_json.h"

#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/loops", 3};
// Far more than an image has.
constexpr Range kCorners{0, 1'000'000};

void Describe(JsonVisitor& visitor, ObjectMerge& merge) {
  visitor.Field("kept", merge.kept);
  visitor.Field("merged", merge.merged);
}

void Describe(JsonVisitor& visitor, Constellation& constellation) {
  visitor.Field("pairs", constellation.pairs);
  visitor.Field("old_world_from_new_world", constellation.old_world_from_new_world);
  visitor.Field("position_error_m", constellation.position_error_m);
  visitor.Field("accepted", constellation.accepted);
  visitor.Field("reason", constellation.reason);
}

void Describe(JsonVisitor& visitor, AppearanceLoop& loop) {
  visitor.Field("old_keyframe", loop.old_keyframe);
  visitor.Field("new_keyframe", loop.new_keyframe);
  visitor.Field("old_from_new", loop.old_from_new);
  visitor.Field("num_inliers", loop.num_inliers, kCorners);
  visitor.Field("num_support", loop.num_support, kCorners);
  visitor.Field("agreement", loop.agreement);
  visitor.Field("accepted", loop.accepted);
  visitor.Field("reason", loop.reason);
}

void Describe(JsonVisitor& visitor, RelativePose& edge) {
  visitor.Field("i", edge.i);
  visitor.Field("j", edge.j);
  visitor.Field("i_from_j", edge.i_from_j);
  visitor.Field("information", edge.information);
  visitor.Field("composed", edge.composed);
}

void Describe(JsonVisitor& visitor, SplitTracklet& tracklet) {
  visitor.Field("visit", tracklet.tracklet);
  visitor.Field("object", tracklet.object);
  visitor.Field("first", tracklet.first);
  visitor.Field("last", tracklet.last);
}

void Describe(JsonVisitor& visitor, Loops& loops) {
  visitor.Table("constellations", loops.constellations);
  visitor.Field("merges", loops.merges);
  visitor.Table("edges", loops.edges);
  visitor.Table("appearance", loops.appearance);
  visitor.Table("visits", loops.tracklets);
}

Result<std::string> EncodeLoops(const Loops& loops, std::string_view name) {
  return EncodeDocument(kFormat, loops, name);
}

Result<Loops> DecodeLoops(TextSource text, std::string_view name) {
  return DecodeDocument<Loops>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
