// Small things that lie about: boxes, books, cups. They belong to no object of the truth.
#pragma once

#include <vector>

#include "deepslam/synth/world.h"

namespace deepslam::synth {

// Things on the tops of tables and on the free floor, in world coordinates, coloured; drawn from
// the scene's seed. What finds no place is left out.
std::vector<TriangleMesh> MakeClutter(const SceneDescription& description,
                                      const std::vector<PlacedObject>& objects);

}  // namespace deepslam::synth
