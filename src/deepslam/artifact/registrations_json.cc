#include "deepslam/artifact/registrations_json.h"

#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {

using Registrations = std::vector<CandidateRegistration>;

constexpr JsonFormat kFormat{"deepslam/registrations", 1};

void Describe(JsonVisitor& visitor, CandidateRegistration& registration) {
  visitor.Field("candidate", registration.candidate);
  visitor.Field("ok", registration.ok);
  visitor.Field("reason", registration.reason);
  visitor.Field("scale_m", registration.scale_m, kSizeM);
  visitor.Field("world_from_object", registration.world_from_object);
  visitor.Field("views", registration.views);
}

namespace {

void DescribeFile(JsonVisitor& visitor, Registrations& registrations) {
  visitor.Table("registrations", registrations);
}

}  // namespace

Result<std::string> EncodeRegistrations(const Registrations& registrations, std::string_view name) {
  return EncodeDocument(kFormat, registrations, name, DescribeFile);
}

Result<Registrations> DecodeRegistrations(TextSource text, std::string_view name) {
  return DecodeDocument<Registrations>(kFormat, std::move(text), name, DescribeFile);
}

}  // namespace deepslam::artifact
