// registrations.json: where every candidate stands in every view of its object.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/registration.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeRegistrations(
    std::span<const CandidateRegistration> registrations, std::string_view name);
[[nodiscard]] Result<std::vector<CandidateRegistration>> DecodeRegistrations(TextSource text,
                                                                             std::string_view name);

// One view, as it also stands in objects.json.
[[nodiscard]] JsonValue ToJson(const ViewRegistration& view);
[[nodiscard]] ViewRegistration ReadViewRegistration(const JsonNode& node);

}  // namespace deepslam::artifact
