// Which frames show surface that earlier ones did not, or not from that side, or not so near. What
// a detector says of a thing depends on where it is seen from: it tells little more of what it was
// shown from there several times.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::detect {

// A cell of the world with the direction and the distance that it is seen from.
using SeenCell = std::uint64_t;

// The cells that a frame shows, ascending, each once; none of it without depth (0 = invalid).
[[nodiscard]] std::vector<SeenCell> SeenCells(const DepthImage& depth_m,
                                              const PinholeCamera& camera,
                                              const Pose3& world_from_camera);

// One per frame, in their order: whether it shows something that the frames before it, of those
// that do so, have not shown several times. A frame without cells does.
[[nodiscard]] std::vector<bool> ShowNewSurface(std::span<const std::vector<SeenCell>> frames);

}  // namespace deepslam::detect
