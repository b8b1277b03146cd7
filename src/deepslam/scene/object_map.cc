#include "deepslam/scene/object_map.h"

#include <fmt/format.h>

namespace deepslam {

std::string ObjectName(const MapObject& object) {
  return fmt::format("{}_{:02d}", object.class_name, object.id.value);
}

}  // namespace deepslam
