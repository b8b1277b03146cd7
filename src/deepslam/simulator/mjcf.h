// The scene for MuJoCo.
#pragma once

#include <span>
#include <string>

#include "deepslam/simulator/named_thing.h"

namespace deepslam::simulator {

// Meshes lie in the folder `meshes` beside the file.
[[nodiscard]] std::string MjcfText(std::span<const NamedThing> things, const SimulatorScene& scene);

}  // namespace deepslam::simulator
