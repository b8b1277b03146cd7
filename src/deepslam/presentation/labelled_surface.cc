#include "deepslam/presentation/labelled_surface.h"

#include <cstddef>

namespace deepslam::presentation {
namespace {

constexpr Rgb8 kPlain{176, 170, 160};  // of surfaces without colours of their own

void Append(const TriangleMesh& mesh,
            const Pose3& world_from_mesh,
            Rgb8 plain,
            int label,
            LabelledSurface& surface) {
  const auto first = static_cast<std::uint32_t>(surface.mesh.vertices.size());
  for (const Eigen::Vector3f& p : mesh.vertices) {
    surface.mesh.vertices.emplace_back((world_from_mesh * p.cast<double>()).cast<float>());
  }
  for (const auto& face : mesh.faces) {
    surface.mesh.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    surface.mesh.colours.push_back(mesh.colours.empty() ? plain : mesh.colours[v]);
  }
  surface.labels.resize(surface.mesh.vertices.size(), label);
}

}  // namespace

LabelledSurface JoinSurfaces(const gltf::GltfScene& scene) {
  LabelledSurface surface;
  for (const gltf::GltfObject& object : scene.objects) {
    Append(object.mesh, object.world_from_object, object.class_colour, object.instance, surface);
  }
  for (const gltf::GltfPart& part : scene.parts)
    Append(part.mesh_world, {}, part.colour, kPartLabel, surface);
  if (scene.ground) Append(*scene.ground, {}, kPlain, kGroundLabel, surface);
  if (scene.room) Append(*scene.room, {}, kPlain, kRoomLabel, surface);
  return surface;
}

}  // namespace deepslam::presentation
