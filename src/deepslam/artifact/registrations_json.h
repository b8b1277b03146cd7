// registrations.json: where every candidate stands in every view of its object.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/registration.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeRegistrations(
    const std::vector<CandidateRegistration>& registrations, std::string_view name);
[[nodiscard]] Result<std::vector<CandidateRegistration>> DecodeRegistrations(TextSource text,
                                                                             std::string_view name);

}  // namespace deepslam::artifact
