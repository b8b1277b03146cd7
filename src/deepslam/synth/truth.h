// The truth about a rendered capture, as text for truth/objects.json.
#pragma once

#include <string>

#include "deepslam/synth/world.h"

namespace deepslam::synth {

// {"format": "deepslam-truth/1", "room": "room.ply", "objects": [{"id", "class", "model", "mesh",
// "size_m", "scale_m", "translation_m", "rotation_xyzw"}]}: world_from_object (z up, x front,
// origin at the middle of the box), metric meshes in the object frame at "meshes/<id>.ply" beside
// it. `scale_m` makes the pose a similarity from the unit-cube object frame of voxel_grid.h.
std::string TruthJson(const World& world);

}  // namespace deepslam::synth
