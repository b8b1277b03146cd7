// What a frame is recognised by: points of its image that have depth, with descriptors. Corners
// with binary descriptors (ORB, Rublee et al. 2011) of every keyframe; and blobs with descriptors
// of gradients (SIFT, Lowe 2004), which are found in blur and between views further apart, and take
// ten times as long, where a frame is lost. Both as OpenCV computes them.
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

using GradientDescriptor = std::array<std::uint8_t, 128>;  // ... by their squared distance

template <typename Descriptor>
struct FeaturesOf {
  FrameIdx keyframe;
  // One entry per point, strongest first.
  std::vector<Descriptor> descriptors;
  std::vector<Eigen::Vector3f> points_camera;  // m
};

using KeyframeFeatures = FeaturesOf<BinaryDescriptor>;
using GradientFeatures = FeaturesOf<GradientDescriptor>;

// At most `max_features`, spread over the image. Points without depth, and those at steps of depth,
// are left out. None for a frame without colour, without depth or with images of different sizes.
// Deterministic.
[[nodiscard]] KeyframeFeatures ExtractFeatures(const Frame& frame,
                                               const PinholeCamera& camera,
                                               int max_features);
[[nodiscard]] GradientFeatures ExtractGradientFeatures(const Frame& frame,
                                                       const PinholeCamera& camera,
                                                       int max_features);

// Unequal bits, 0 to 256.
[[nodiscard]] inline int Distance(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  int unequal = 0;
  for (std::size_t k = 0; k < a.size(); ++k) unequal += std::popcount(a[k] ^ b[k]);
  return unequal;
}

// Squared, 0 to 128 * 255^2.
[[nodiscard]] inline int Distance(const GradientDescriptor& a, const GradientDescriptor& b) {
  int sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const int difference = static_cast<int>(a[k]) - static_cast<int>(b[k]);
    sum += difference * difference;
  }
  return sum;
}

}  // namespace deepslam::loop
