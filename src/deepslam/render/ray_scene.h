// Triangle meshes that rays can be cast at (Embree). Distances and normals are in world metres.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::render {

struct RayHit {
  double distance_m = 0;  // along the unit direction
  Eigen::Vector3f normal_world =
      Eigen::Vector3f::Zero();  // of the face, unit, towards the ray's origin
  int instance = -1;            // as AddMesh returned it
  std::uint32_t face = 0;       // of the instance's mesh
  // Barycentric weights of the face's second and third corner.
  float weight_b = 0;
  float weight_c = 0;
};

class RayScene {
 public:
  RayScene();
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  // Places a mesh; the instance's number, counted from 0. Refuses meshes that are empty, have a
  // face that names a vertex that is not there, or a vertex that is not finite.
  Result<int> AddMesh(const TriangleMesh& mesh, const Pose3& world_from_mesh);

  // Ends adding. Rays may be cast afterwards only, then from any number of threads.
  void Commit();

  [[nodiscard]] int num_instances() const;

  // Nearest hit between min_m and max_m along `direction` (unit). Faces are hit from both sides.
  [[nodiscard]] std::optional<RayHit> Cast(const Eigen::Vector3f& origin,
                                           const Eigen::Vector3f& direction,
                                           float min_m = 0.0f,
                                           float max_m = 1e6f) const;

  // The nearest hits of rays from one origin, in the order of `directions` (unit); `instance` is -1
  // where nothing is hit. Quicker than Cast where neighbours in the list run side by side.
  void CastFan(const Eigen::Vector3f& origin,
               std::span<const Eigen::Vector3f> directions,
               std::span<RayHit> hits) const;

  // Whether anything lies between two points; `margin_m` at both ends is not looked at.
  [[nodiscard]] bool Occluded(const Eigen::Vector3f& from,
                              const Eigen::Vector3f& to,
                              float margin_m = 1e-3f) const;

  // The same for many pairs of points at once, 0 or 1 each. Quicker than Occluded where neighbours
  // in the list run side by side.
  void AreOccluded(std::span<const Eigen::Vector3f> from,
                   std::span<const Eigen::Vector3f> to,
                   std::span<std::uint8_t> occluded,
                   float margin_m = 1e-3f) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deepslam::render
