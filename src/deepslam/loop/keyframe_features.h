// What a keyframe is recognised by: corners that have depth, with binary descriptors (ORB, Rublee
// et al. 2011, as OpenCV computes it).
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::loop {

using BinaryDescriptor = std::array<std::uint64_t, 4>;  // compared by the number of unequal bits

struct KeyframeFeatures {
  FrameIdx keyframe;
  // One entry per corner, strongest first.
  std::vector<BinaryDescriptor> descriptors;
  std::vector<Eigen::Vector3f> points_camera;  // m
};

// At most `max_features`, spread over the image. Corners without depth, and those at steps of
// depth, are left out. None for a frame without colour, without depth or with images of different
// sizes. Deterministic.
[[nodiscard]] KeyframeFeatures ExtractFeatures(const Frame& frame,
                                               const PinholeCamera& camera,
                                               int max_features);

// Unequal bits, 0 to 256.
[[nodiscard]] inline int Distance(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  int unequal = 0;
  for (std::size_t k = 0; k < a.size(); ++k) unequal += std::popcount(a[k] ^ b[k]);
  return unequal;
}

}  // namespace deepslam::loop
