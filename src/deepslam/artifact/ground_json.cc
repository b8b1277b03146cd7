#include "deepslam/artifact/ground_json.h"

#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/ground";
constexpr int kVersion = 1;

int Degrees(QuarterTurn turn) { return 90 * static_cast<int>(turn); }

QuarterTurn ReadTurn(const JsonNode& node) {
  const int deg = node.Int(0, 270);
  if (deg % 90 != 0) node.Fail("is no quarter turn");
  return static_cast<QuarterTurn>(deg / 90);
}

JsonValue ObservationToJson(const GroundObservation& observation) {
  JsonObject row;
  row.emplace("keyframe", ToJson(observation.keyframe));
  row.emplace("plane_camera", ToJson(observation.plane_camera));
  row.emplace("information", ToJson(observation.information));
  row.emplace("num_inliers", observation.num_inliers);
  return JsonValue(std::move(row));
}

GroundObservation ReadObservation(const JsonNode& row) {
  GroundObservation observation;
  observation.keyframe = ReadId<FrameIdx>(row["keyframe"]);
  observation.plane_camera = ReadPlane(row["plane_camera"]);
  observation.information = ReadMatrix3(row["information"]);
  observation.num_inliers = row["num_inliers"].Int(0, kMaxId);
  return observation;
}

}  // namespace

Result<std::string> EncodeGround(const Ground& ground, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  document.emplace("plane_world", ground.plane_world ? ToJson(*ground.plane_world) : JsonValue());
  document.emplace("observations", RowsOf(ground.observations, ObservationToJson));
  JsonArray apart;
  for (const GroundApart& stretch : ground.apart) {
    JsonObject row;
    row.emplace("first", ToJson(stretch.first));
    row.emplace("end", ToJson(stretch.end));
    row.emplace("plane_world", stretch.plane_world ? ToJson(*stretch.plane_world) : JsonValue());
    apart.emplace_back(std::move(row));
  }
  if (!apart.empty()) document.emplace("apart", std::move(apart));
  if (ground.upright) document.emplace("upright_deg", Degrees(*ground.upright));
  return DumpJson(std::move(document), name);
}

Result<Ground> DecodeGround(TextSource text, std::string_view name) {
  Ground ground;
  JsonReader reader(std::move(text),
                    name,
                    kFormat,
                    kVersion,
                    {{"observations", AppendRows(ground.observations, ReadObservation)}});
  const JsonNode root = reader.root();
  if (const JsonNode plane = root.Maybe("plane_world"); plane.exists())
    ground.plane_world = ReadPlane(plane);
  if (const JsonNode apart = root.Maybe("apart"); apart.exists()) {
    for (const JsonNode& row : apart.Items()) {
      GroundApart stretch{ReadId<FrameIdx>(row["first"]), ReadId<FrameIdx>(row["end"]), {}};
      if (const JsonNode plane = row.Maybe("plane_world"); plane.exists())
        stretch.plane_world = ReadPlane(plane);
      ground.apart.push_back(stretch);
    }
  }
  if (const JsonNode upright = root.Maybe("upright_deg"); upright.exists())
    ground.upright = ReadTurn(upright);
  return reader.Finish(std::move(ground));
}

}  // namespace deepslam::artifact
