// An indexed triangle mesh. Counter-clockwise faces seen from outside. Metres unless a name says
// otherwise.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"

namespace deepslam {

struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::vector<Rgb8> colours;  // one per vertex, or empty

  [[nodiscard]] bool empty() const { return faces.empty(); }
};

}  // namespace deepslam
