// Component types of glTF's accessors (glTF 2.0, 3.6.2.2).
#pragma once

#include <cstdint>

namespace deepslam::gltf {

// Bytes of one component; 0 for what is no component type.
[[nodiscard]] constexpr int ComponentBytes(std::uint64_t component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

}  // namespace deepslam::gltf
