// What is treated alike among the classes that one sits or lies on.
#pragma once

#include <string>

namespace deepslam::tools {

inline bool IsSeat(const std::string& class_name) {
  return class_name == "chair" || class_name == "sofa";
}

inline bool HasBack(const std::string& class_name) {
  return IsSeat(class_name) || class_name == "bed";
}

}  // namespace deepslam::tools
