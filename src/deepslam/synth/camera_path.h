// The way of the camera through a scene.
#pragma once

#include <vector>

#include "deepslam/geometry/pose.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// world_from_camera of every frame: an orbit or a way along a spline that eases in and out (closed
// ways keep their speed), with the sway of a hand (a sum of slow waves with phases drawn from the
// scene's seed, so it is smooth at any frame rate) and, walking, of steps.
std::vector<Pose3> CameraPath(const SceneDescription& description);

// Of a walk's points from end to end, m, with what one would have walked while the view turned.
double WalkLength_m(const SceneWalk& walk);

// Numbers of the frames that are not dropped, ascending; the first one always is there.
std::vector<int> KeptFrames(const SceneDescription& description);

// Factor on the light that the camera's automatic exposure lets in: drifts slowly around 1.
double ExposureGain(const SceneDescription& description, double time_s);

}  // namespace deepslam::synth
