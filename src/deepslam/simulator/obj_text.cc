#include "deepslam/simulator/obj_text.h"

#include <iterator>

#include <fmt/format.h>

namespace deepslam::simulator {

std::string ObjText(const TriangleMesh& mesh) {
  std::string text;
  const bool coloured = mesh.colours.size() == mesh.vertices.size();
  for (std::size_t n = 0; n < mesh.vertices.size(); ++n) {
    const Eigen::Vector3f& p = mesh.vertices[n];
    fmt::format_to(std::back_inserter(text), "v {:.5f} {:.5f} {:.5f}", p.x(), p.y(), p.z());
    if (coloured) {
      const Rgb8& colour = mesh.colours[n];
      fmt::format_to(std::back_inserter(text),
                     " {:.3f} {:.3f} {:.3f}",
                     colour.r / 255.0,
                     colour.g / 255.0,
                     colour.b / 255.0);
    }
    text += '\n';
  }
  for (const auto& face : mesh.faces)
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1);
  return text;
}

}  // namespace deepslam::simulator
