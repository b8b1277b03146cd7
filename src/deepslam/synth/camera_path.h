// The way of the camera through a scene.
#pragma once

#include <vector>

#include "deepslam/geometry/pose.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// world_from_camera of every frame: an orbit that eases in and out, with the sway of a hand (a sum
// of slow waves with phases drawn from the scene's seed, so it is smooth at any frame rate).
std::vector<Pose3> CameraPath(const SceneDescription& description);

}  // namespace deepslam::synth
