// The truth about a rendered capture, as text for truth/objects.json.
#pragma once

#include <string>

#include "deepslam/synth/world.h"

namespace deepslam::synth {

// {"format": "deepslam-truth/1", "objects": [{"id", "class", "model", "mesh", "size_m",
// "translation_m", "rotation_xyzw"}]}: world_from_object (z up, x front, origin at the middle of
// the box), meshes in the object frame at "meshes/<id>.ply" beside it.
std::string TruthJson(const World& world);

}  // namespace deepslam::synth
