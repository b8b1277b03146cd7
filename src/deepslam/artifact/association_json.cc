#include "deepslam/artifact/association_json.h"

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/tracks", 1};

void Describe(JsonVisitor& visitor, TrackMember& member) {
  visitor.Field("detection", member.detection);
  visitor.Field("frame", member.frame);
  visitor.Field("num_votes", member.num_votes);
  visitor.Field("dissimilarity_m", member.dissimilarity_m);
  visitor.Field("how", member.how);
}

void Describe(JsonVisitor& visitor, ObjectTrack& track) {
  visitor.Field("id", track.id);
  visitor.Field("class", track.class_name);
  visitor.Field("reason", track.reason);
  visitor.Maybe("class_votes", track.class_votes);
  visitor.Field("members", track.members);
}

void Describe(JsonVisitor& visitor, Rejection& rejection) {
  visitor.Field("detection", rejection.detection);
  visitor.Field("frame", rejection.frame);
  visitor.Field("reason", rejection.reason);
}

void Describe(JsonVisitor& visitor, Association& association) {
  visitor.Table("tracks", association.tracks);
  visitor.Table("rejections", association.rejections);
  visitor.Maybe("not_mapped", association.not_mapped);
}

Result<std::string> EncodeAssociation(const Association& association, std::string_view name) {
  return EncodeDocument(kFormat, association, name);
}

Result<Association> DecodeAssociation(TextSource text, std::string_view name) {
  return DecodeDocument<Association>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
