#include "deepslam/artifact/registrations_json.h"

#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/registrations";
constexpr int kVersion = 1;

JsonValue RegistrationToJson(const CandidateRegistration& registration) {
  JsonArray views;
  for (const ViewRegistration& view : registration.views) views.push_back(ToJson(view));
  JsonObject row;
  row.emplace("candidate", ToJson(registration.candidate));
  row.emplace("ok", registration.ok);
  row.emplace("reason", registration.reason);
  row.emplace("scale_m", registration.scale_m);
  row.emplace("world_from_object", ToJson(registration.world_from_object));
  row.emplace("views", std::move(views));
  return JsonValue(std::move(row));
}

CandidateRegistration ReadRegistration(const JsonNode& row) {
  CandidateRegistration registration;
  registration.candidate = ReadId<CandidateId>(row["candidate"]);
  registration.ok = row["ok"].Bool();
  registration.reason = row["reason"].String();
  registration.scale_m = row["scale_m"].Number(0, 1e3);
  registration.world_from_object = ReadPose(row["world_from_object"]);
  for (const JsonNode& view : row["views"].Items())
    registration.views.push_back(ReadViewRegistration(view));
  return registration;
}

}  // namespace

JsonValue ToJson(const ViewRegistration& view) {
  JsonObject row;
  row.emplace("view", ToJson(view.view));
  row.emplace("frame", ToJson(view.frame));
  row.emplace("ok", view.ok);
  row.emplace("reason", view.reason);
  row.emplace("camera_from_object", ToJson(view.camera_from_object));
  row.emplace("rmse_m", view.rmse_m);
  row.emplace("inlier_share", view.inlier_share);
  row.emplace("information", ToJson(view.information));
  row.emplace("yaw_free", view.yaw_free);
  return JsonValue(std::move(row));
}

ViewRegistration ReadViewRegistration(const JsonNode& row) {
  ViewRegistration view;
  view.view = ReadId<DetectionId>(row.Maybe("view"));
  view.frame = ReadId<FrameIdx>(row.Maybe("frame"));
  view.ok = row["ok"].Bool();
  view.reason = row["reason"].String();
  view.camera_from_object = ReadPose(row["camera_from_object"]);
  view.rmse_m = row["rmse_m"].Number();
  view.inlier_share = row["inlier_share"].Number();
  view.information = ReadMatrix6(row["information"]);
  view.yaw_free = row["yaw_free"].Bool();
  return view;
}

Result<std::string> EncodeRegistrations(std::span<const CandidateRegistration> registrations,
                                        std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  document.emplace("registrations", RowsOf(registrations, RegistrationToJson));
  return DumpJson(std::move(document), name);
}

Result<std::vector<CandidateRegistration>> DecodeRegistrations(TextSource text,
                                                               std::string_view name) {
  std::vector<CandidateRegistration> registrations;
  const JsonReader reader(std::move(text),
                          name,
                          kFormat,
                          kVersion,
                          {{"registrations", AppendRows(registrations, ReadRegistration)}});
  return reader.Finish(std::move(registrations));
}

}  // namespace deepslam::artifact
