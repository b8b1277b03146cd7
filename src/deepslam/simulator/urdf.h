// The scene, and single things of it, as URDF.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "deepslam/simulator/named_thing.h"

namespace deepslam::simulator {

// A link `world` with a link per thing: fixed joints for what stays where it is, floating ones for
// what is free. Meshes lie in the folder `meshes` beside the file.
[[nodiscard]] std::string UrdfText(std::span<const NamedThing> things, const SimulatorScene& scene);

// Everything that stays where it is, and the floor.
[[nodiscard]] std::string FixedUrdfText(std::span<const NamedThing> things,
                                        const SimulatorScene& scene);

// One thing alone, in its own frame; `mesh_folder` is relative to the file.
[[nodiscard]] std::string ThingUrdfText(const NamedThing& named, std::string_view mesh_folder);

}  // namespace deepslam::simulator
