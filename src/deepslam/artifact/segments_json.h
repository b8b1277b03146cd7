// segments.json: the pixels of every detection that are the object, masks as COCO run lengths.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/detection.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeSegments(std::span<const Segment> segments,
                                                 std::string_view name);
[[nodiscard]] Result<std::vector<Segment>> DecodeSegments(std::string_view text,
                                                          std::string_view name);

}  // namespace deepslam::artifact
