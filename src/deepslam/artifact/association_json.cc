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

void Describe(JsonVisitor& visitor, SeenIn& seen) {
  visitor.Field("frame", seen.frame);
  visitor.Field("bbox", seen.box_px);
}

// Two lists, as files without the second are read as well.
void DescribeNotMapped(JsonVisitor& visitor, std::vector<NotMapped>& not_mapped) {
  std::vector<std::string> texts;
  std::vector<SeenIn> seen;
  for (const NotMapped& thing : not_mapped) {
    texts.push_back(thing.what);
    seen.push_back(thing.best);
  }
  visitor.Maybe("not_mapped", texts);
  visitor.Maybe("not_mapped_seen", seen);
  if (!visitor.reading()) return;
  seen.resize(texts.size());
  not_mapped.clear();
  for (std::size_t n = 0; n < texts.size(); ++n) not_mapped.push_back({texts[n], seen[n]});
}

void Describe(JsonVisitor& visitor, Association& association) {
  visitor.Table("tracks", association.tracks);
  visitor.Table("rejections", association.rejections);
  DescribeNotMapped(visitor, association.not_mapped);
}

Result<std::string> EncodeAssociation(const Association& association, std::string_view name) {
  return EncodeDocument(kFormat, association, name);
}

Result<Association> DecodeAssociation(TextSource text, std::string_view name) {
  return DecodeDocument<Association>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
