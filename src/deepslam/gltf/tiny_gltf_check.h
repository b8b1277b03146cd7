// Loading by tinygltf, with Draco: does another program's reader take the file?
#pragma once

#include <string>
#include <string_view>

namespace deepslam::gltf {

// Empty when tinygltf loads the file without error or warning, else what it said.
[[nodiscard]] std::string LoadByTinyGltf(std::string_view bytes);

}  // namespace deepslam::gltf
