// Pyramids of rendered frames, as tests of alignment compare them.
#pragma once

#include <cstdint>
#include <memory>

#include "alignment/box_world.h"
#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/reference_pixels.h"

namespace deepslam::testing_support {

inline std::shared_ptr<const alignment::FramePyramid> Seen(const BoxWorld& world,
                                                           const Pose3& world_from_camera,
                                                           std::uint64_t seed = 0) {
  return std::make_shared<const alignment::FramePyramid>(
      alignment::BuildPyramid(RenderFrame(world, world_from_camera, 1.0, seed), kSmallCamera, {}));
}

inline alignment::FramePyramid Furnished(const Pose3& world_from_camera, std::uint64_t seed = 1) {
  const Frame frame = RenderFrame(BoxWorld::Furnished(), world_from_camera, 1.0, seed);
  return alignment::AsReference(alignment::BuildPyramid(frame, kSmallCamera, {}));
}

}  // namespace deepslam::testing_support
