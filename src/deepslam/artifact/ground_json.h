// ground.json: the ground plane per keyframe and for the world.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/ground.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeGround(const Ground& ground, std::string_view name);
[[nodiscard]] Result<Ground> DecodeGround(TextSource text, std::string_view name);

}  // namespace deepslam::artifact
