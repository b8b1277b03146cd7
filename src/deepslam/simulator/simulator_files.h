// The folder that simulators load a scene from.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/simulator/simulator_scene.h"

namespace deepslam::simulator {

using WriteFile = std::function<Status(std::string_view file, std::string_view bytes)>;

// scene.xml (MJCF), scene.urdf, scene_fixed.urdf (what stays where it is, and the floor), scene.sdf
// (Gazebo), objects/NAME.urdf of each free thing, meshes/NAME.obj (as seen),
// meshes/NAME_piece_N.obj, and placements.json: where each free thing stands, for those who load
// them one by one. Handed to `write` one after another; its first error ends it. Errors of our own
// (kInvalidInput), with the thing's name: indices out of range, coordinates, a pose or a mass that
// are not finite.
[[nodiscard]] Status WriteSimulatorFiles(const SimulatorScene& scene, const WriteFile& write);

}  // namespace deepslam::simulator
