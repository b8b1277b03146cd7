// Light that reaches the surfaces a camera sees: lamps with soft shadows, and the surroundings.
#pragma once

#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/render/ray_scene.h"
#include "deepslam/render/render_view.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// Light per pixel, of a white surface; 0 where nothing is hit. What is seen of each lamp and of the
// surroundings is sampled on every second pixel, one ray each from a pattern of 4 x 4, and meaned
// over the pattern on the same surface; distance and angle to the lamps are each pixel's own.
Image<float> SurfaceLight(const render::RayScene& scene,
                          const render::RenderedView& view,
                          const SceneDescription& description,
                          const PinholeCamera& camera,
                          const Pose3& world_from_camera);

}  // namespace deepslam::synth
