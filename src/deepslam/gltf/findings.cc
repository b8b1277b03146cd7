#include "deepslam/gltf/findings.h"

namespace deepslam::gltf {

void Findings::Error(const std::string& place, const std::string& what) {
  ++num_errors;
  if (errors.size() < kMaxFindings) errors.push_back(place + ": " + what);
}

void Findings::Breach(const std::string& place, const std::string& what) {
  if (strict) Error(place, what);
}

void Findings::Warn(const std::string& place, const std::string& what) {
  if (warnings.size() < kMaxFindings) warnings.push_back(place + ": " + what);
}

}  // namespace deepslam::gltf
