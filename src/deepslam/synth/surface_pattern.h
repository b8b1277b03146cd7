// Procedural surfaces of a room, so that there is texture to look at: boards, carpet, tiles,
// plaster, posters.
#pragma once

#include <cstdint>
#include <string_view>

#include <Eigen/Core>

#include "deepslam/core/image.h"

namespace deepslam::synth {

// Smooth noise in [-1, 1] with features of unit size; a function of place and seed alone.
double SmoothNoise(const Eigen::Vector3d& p, std::uint64_t seed);

// Linear reflectance in [0, 1] at (u, v) metres.
Eigen::Vector3f FloorColour(std::string_view kind, const Eigen::Vector2d& p_m, std::uint64_t seed);
Eigen::Vector3f WallColour(const Rgb8& paint, const Eigen::Vector2d& p_m, std::uint64_t seed);
// Poster `number` with the given extent; p_m from its corner.
Eigen::Vector3f PosterColour(int number,
                             const Eigen::Vector2d& p_m,
                             const Eigen::Vector2d& extent_m,
                             std::uint64_t seed);

// sRGB to linear.
Eigen::Vector3f Linear(const Rgb8& colour);

}  // namespace deepslam::synth
