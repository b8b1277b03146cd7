// A mesh as glTF stores it: y-up axes, one normal per vertex, linear colours.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::gltf {

struct RenderMesh {
  std::vector<Eigen::Vector3f> positions;             // glTF axes
  std::vector<Eigen::Vector3f> normals;               // unit
  std::vector<std::array<std::uint16_t, 4>> colours;  // linear RGBA, normalised; or empty
  std::vector<std::array<std::uint32_t, 3>> faces;
};

// glTF's frame from ours (z up, x front, y left): (x, y, z) becomes (y, z, x), a proper rotation.
[[nodiscard]] inline Eigen::Vector3f ToGltfAxes(const Eigen::Vector3f& p) {
  return {p.y(), p.z(), p.x()};
}
[[nodiscard]] inline Eigen::Vector3d ToGltfAxes(const Eigen::Vector3d& p) {
  return {p.y(), p.z(), p.x()};
}
// world_from_a with both frames in glTF's axes.
[[nodiscard]] inline Pose3 ToGltfAxes(const Pose3& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  return {Eigen::Quaterniond(q.w(), q.y(), q.z(), q.x()), ToGltfAxes(pose.translation_m)};
}

// glTF's cameras look along -z with y up; ours along z with y down.
[[nodiscard]] inline Pose3 GltfCameraPose(const Pose3& world_from_camera) {
  const Eigen::Quaterniond camera_from_gltf_camera(0, 1, 0, 0);  // half a turn about x
  // The world's axes change, the camera's do not: they are the viewer's own.
  const Eigen::Quaterniond gltf_world_from_world(0.5, -0.5, -0.5, -0.5);
  return {gltf_world_from_world * world_from_camera.rotation * camera_from_gltf_camera,
          ToGltfAxes(world_from_camera.translation_m)};
}

// sRGB to linear light, 16 bit (glTF's vertex colours and factors are linear).
[[nodiscard]] std::uint16_t LinearFromSrgb(std::uint8_t value);

// Vertices at one place are one vertex, faces without area to two of whose corners that happens are
// left out, and vertices are doubled where faces meet at more than `crease_angle_rad`. The mesh
// must be valid (indices, finite).
[[nodiscard]] RenderMesh MakeRenderMesh(const TriangleMesh& mesh, double crease_angle_rad);

}  // namespace deepslam::gltf
