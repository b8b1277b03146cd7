#include "deepslam/scene/object_map.h"

#include "deepslam/scene/object_name.h"

namespace deepslam {

std::string ObjectName(const MapObject& object) { return ObjectName(object.class_name, object.id); }

}  // namespace deepslam
