// What a scene of the program's own has to be, before anybody looks at its geometry.
#pragma once

#include <string>
#include <vector>

#include "deepslam/gltf/gltf_buffers.h"
#include "deepslam/gltf/json_place.h"

namespace deepslam::gltf {

// Every buffer view, accessor, primitive, node and scene, used or not: indices in range, bytes
// there and aligned, materials of variants, nothing outside the GLB. Findings are the document's.
void CheckStructure(const JsonPlace& root, GltfBuffers& buffers);

// Names of the appearances a scene can be switched between (KHR_materials_variants).
[[nodiscard]] std::vector<std::string> VariantsOf(const JsonPlace& root);

}  // namespace deepslam::gltf
