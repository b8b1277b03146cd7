// tracks.json: which detections are the same object, and why.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/object_track.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeAssociation(const Association& association,
                                                    std::string_view name);
[[nodiscard]] Result<Association> DecodeAssociation(TextSource text, std::string_view name);

}  // namespace deepslam::artifact
