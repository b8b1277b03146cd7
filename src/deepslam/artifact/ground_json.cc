#include "deepslam/artifact/ground_json.h"

#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/ground", 1};

// Its degrees.
void Describe(JsonVisitor& visitor, QuarterTurn& turn) {
  int deg = 90 * static_cast<int>(turn);
  visitor.Value(deg, Range{0, 270});
  if (deg % 90 != 0) visitor.Fail({}, "is no quarter turn");
  if (visitor.reading()) turn = static_cast<QuarterTurn>(deg / 90);
}

void Describe(JsonVisitor& visitor, GroundObservation& observation) {
  visitor.Field("keyframe", observation.keyframe);
  visitor.Field("plane_camera", observation.plane_camera);
  visitor.Field("information", observation.information);
  visitor.Field("num_inliers", observation.num_inliers);
}

void Describe(JsonVisitor& visitor, GroundApart& apart) {
  visitor.Field("first", apart.first);
  visitor.Field("end", apart.end);
  visitor.Maybe("plane_world", apart.plane_world);
}

void Describe(JsonVisitor& visitor, Ground& ground) {
  visitor.Maybe("plane_world", ground.plane_world);
  visitor.Table("observations", ground.observations);
  visitor.Maybe("apart", ground.apart, !ground.apart.empty());
  visitor.Maybe("upright_deg", ground.upright, ground.upright.has_value());
}

Result<std::string> EncodeGround(const Ground& ground, std::string_view name) {
  return EncodeDocument(kFormat, ground, name);
}

Result<Ground> DecodeGround(TextSource text, std::string_view name) {
  return DecodeDocument<Ground>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
