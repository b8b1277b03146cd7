// What an object is called before it is one of the map: as the map will call it (object_map.h).
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/ids.h"

namespace deepslam {

// "chair_03".
[[nodiscard]] std::string ObjectName(std::string_view class_name, ObjectId id);

}  // namespace deepslam
