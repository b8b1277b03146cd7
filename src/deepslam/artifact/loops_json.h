// loops.json: constellations and keyframes seen again, the objects they merge, the edges they add
// to the graph.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/loop.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeLoops(const Loops& loops, std::string_view name);
[[nodiscard]] Result<Loops> DecodeLoops(TextSource text, std::string_view name);

}  // namespace deepslam::artifact
