#include "deepslam/scene/object_name.h"

#include <fmt/format.h>

namespace deepslam {

std::string ObjectName(std::string_view class_name, ObjectId id) {
  return fmt::format("{}_{:02d}", class_name, id.value);
}

}  // namespace deepslam
