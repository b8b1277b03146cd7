// layout.json: rooms, walls, openings, levels and slanted planes, in the level world.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/layout.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeLayout(const Layout& layout, std::string_view name);
// Ids that name nothing, outlines that are no polygons and heights the wrong way round are refused.
[[nodiscard]] Result<Layout> DecodeLayout(TextSource text, std::string_view name);

}  // namespace deepslam::artifact
