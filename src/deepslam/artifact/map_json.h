// map.json: the compact map (scene/compact_map.h).
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/compact_map.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeMap(const CompactMap& map, std::string_view name);
[[nodiscard]] Result<CompactMap> DecodeMap(TextSource text, std::string_view name);

}  // namespace deepslam::artifact
