// The scene for Gazebo.
#pragma once

#include <span>
#include <string>

#include "deepslam/simulator/named_thing.h"

namespace deepslam::simulator {

// SDFormat 1.7: a world with one model per thing. Meshes lie in the folder `meshes` beside the
// file.
[[nodiscard]] std::string SdfText(std::span<const NamedThing> things, const SimulatorScene& scene);

}  // namespace deepslam::simulator
