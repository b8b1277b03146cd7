// Pictures of meshes for people: the report's views of a map.
#pragma once

#include <memory>
#include <span>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::render {

struct ShadedMesh {
  TriangleMesh mesh;
  Pose3 world_from_mesh;
  Rgb8 colour{200, 200, 200};  // where the mesh has no vertex colours, or they are not wanted
  bool use_vertex_colours = false;
};

// The meshes on white, lit by the sky and a lamp high above the world's origin side, with its
// shadow; world z up. Meshes that cannot be rendered (empty, not finite) are left out.
class ShadedScene {
 public:
  // The meshes must live as long as the scene.
  explicit ShadedScene(std::span<const ShadedMesh> meshes);
  ~ShadedScene();
  ShadedScene(const ShadedScene&) = delete;
  ShadedScene& operator=(const ShadedScene&) = delete;

  // One ray through each pixel's middle, four through those at edges. Same result for any number of
  // threads.
  [[nodiscard]] ColourImage View(const PinholeCamera& camera, const Pose3& world_from_camera) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A single view.
[[nodiscard]] ColourImage ShadeView(std::span<const ShadedMesh> meshes,
                                    const PinholeCamera& camera,
                                    const Pose3& world_from_camera);

// A camera that looks at `target` from `position`, upright; both world, z up, not above one
// another.
[[nodiscard]] Pose3 LookAt(const Eigen::Vector3d& position_world,
                           const Eigen::Vector3d& target_world);

// A pose from which the whole box is seen by `camera`, from azimuth (about z, 0 = +x) and
// elevation.
[[nodiscard]] Pose3 Overlook(const Box3& box_world,
                             const PinholeCamera& camera,
                             double azimuth_rad,
                             double elevation_rad);

}  // namespace deepslam::render
