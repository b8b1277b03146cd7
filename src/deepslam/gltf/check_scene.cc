#include "deepslam/gltf/check_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "deepslam/core/utf8.h"

namespace deepslam::gltf {

Status CheckMeshInput(const TriangleMesh& mesh, const std::string& name) {
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!mesh.vertices[v].allFinite()) {
      return InvalidInput(name + ": vertex " + std::to_string(v) + " is not finite");
    }
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const std::uint32_t v : mesh.faces[f]) {
      if (v >= mesh.vertices.size()) {
        return InvalidInput(name + ": face " + std::to_string(f) + " has index " +
                            std::to_string(v) + " of " + std::to_string(mesh.vertices.size()) +
                            " vertices");
      }
    }
  }
  if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertices.size()) {
    return InvalidInput(name + ": " + std::to_string(mesh.colours.size()) + " colours for " +
                        std::to_string(mesh.vertices.size()) + " vertices");
  }
  return Ok();
}

Status CheckPose(const Pose3& pose, const std::string& name) {
  const double norm = pose.rotation.norm();
  if (!pose.translation_m.allFinite() || !std::isfinite(norm) || norm < 1e-6) {
    return InvalidInput(name + ": pose is not finite");
  }
  return Ok();
}

std::string UniqueName(const GltfObject& object, std::set<std::string>& taken) {
  std::string name = ToValidUtf8(object.name);
  if (name.empty()) {
    const std::string number = std::to_string(object.instance);
    name = ToValidUtf8(object.class_name) + "_" + (number.size() < 2 ? "0" : "") + number;
  }
  return UniqueName(name, taken);
}

std::string UniqueName(const std::string& name, std::set<std::string>& taken) {
  std::string unique = ToValidUtf8(name);
  for (int n = 2; !taken.insert(unique).second; ++n)
    unique = ToValidUtf8(name) + "_" + std::to_string(n);
  return unique;
}

bool IsScaledCopy(const TriangleMesh& mesh, const TriangleMesh& first, double ratio) {
  // Of coordinates; Draco's grid is five times coarser.
  constexpr float kCoordinateRounding = 1e-5F;
  if (mesh.faces != first.faces || mesh.vertices.size() != first.vertices.size()) return false;
  float extent = 0;
  for (const Eigen::Vector3f& p : mesh.vertices) extent = std::max(extent, p.cwiseAbs().maxCoeff());
  const auto factor = static_cast<float>(ratio);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3f error = mesh.vertices[v] - factor * first.vertices[v];
    if (!(error.cwiseAbs().maxCoeff() <= kCoordinateRounding * extent)) return false;
  }
  return true;
}

}  // namespace deepslam::gltf
