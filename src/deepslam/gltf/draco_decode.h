// Meshes out of Draco's bytes, of this program and of any other.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"

namespace deepslam::gltf {

// Draco's unique ids of attributes; -1 = none.
struct DracoAttributeIds {
  int position = -1;
  int normal = -1;
  int place = -1;  // in the texture
  int colour = -1;
  // Of scenes of the program's own: positions and normals have to be finite floats, else numbers of
  // any type will do; and there have to be `others` that are not given out, of one to four numbers.
  bool strict = false;
  std::vector<int> others = {};
};

struct DracoMesh {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;  // these three: empty = none, or not of as many numbers
  std::vector<Eigen::Vector2f> places;
  std::vector<Eigen::Vector3f> colours;             // without alpha; integers brought to [0, 1]
  std::vector<std::array<std::uint32_t, 3>> faces;  // that name positions
};

// Damaged and hostile bytes give an error, and nothing large is allocated for few of them.
[[nodiscard]] Result<DracoMesh> DracoDecode(std::string_view bytes, const DracoAttributeIds& ids);

}  // namespace deepslam::gltf
