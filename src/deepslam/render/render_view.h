// What a pinhole camera sees of a scene, per pixel, without noise.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/render/ray_scene.h"

namespace deepslam::render {

struct RenderedView {
  DepthImage depth_m;  // along the optical axis; 0 where nothing is hit
  Image<RayHit> hits;  // instance -1 where nothing is hit
};

// Row v of a view, one ray through each pixel's centre; the spans are as long as the row. For those
// who need no whole view at once.
void RenderRow(const RayScene& scene,
               const PinholeCamera& camera,
               const Pose3& world_from_camera,
               int v,
               std::span<RayHit> hits,
               std::span<float> depth_m);

// One ray through each pixel's centre. The result does not depend on the number of threads.
RenderedView RenderView(const RayScene& scene,
                        const PinholeCamera& camera,
                        const Pose3& world_from_camera);

}  // namespace deepslam::render
