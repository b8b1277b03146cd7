// Homes made up by a seed: several rooms with doors between them, furnished as people do it, and a
// way through them as people film.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// What there is to furnish with: catalogue ids and sizes along x (front), y, z.
using PieceSizes = std::map<std::string, Eigen::Vector3d>;

// The catalogue's pieces that homes use, whether or not they are there.
[[nodiscard]] std::vector<std::string> HomePieces();

// Chairs stand pushed under tables, cabinets in rows along walls, nightstands at beds, things on
// furniture, wall cabinets above counters; nothing stands before a door or, if it is high, before a
// window. Kinds of which `sizes` has no piece are left out. The same seed and sizes give the same
// home.
[[nodiscard]] SceneDescription FurnishHome(std::uint64_t seed, const PieceSizes& sizes);

}  // namespace deepslam::synth
