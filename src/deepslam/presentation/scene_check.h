// Whether a scene file and a compact map tell of the same objects.
#pragma once

#include <string>
#include <vector>

#include "deepslam/gltf/validate.h"
#include "deepslam/scene/compact_map.h"

namespace deepslam::presentation {

// The disagreements, each naming the object and both values; empty when scene and map agree:
// every object of either is in the other, with the same name, class, source, confidence, pose and
// size to within what the map's numbers are rounded to, and both have a ground or neither.
[[nodiscard]] std::vector<std::string> CompareWithMap(const gltf::ValidationReport& scene,
                                                      const CompactMap& map);

}  // namespace deepslam::presentation
