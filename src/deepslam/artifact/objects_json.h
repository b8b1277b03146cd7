// objects.json: the objects of the map with pose, scale, views, every candidate's score and why the
// winner won.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/object_map.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeObjectMap(const ObjectMap& map, std::string_view name);
[[nodiscard]] Result<ObjectMap> DecodeObjectMap(TextSource text, std::string_view name);

}  // namespace deepslam::artifact
