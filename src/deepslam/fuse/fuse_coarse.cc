#include "deepslam/fuse/fuse_coarse.h"

#include <cstddef>
#include <utility>

#include "deepslam/frames/for_frames.h"

namespace deepslam::fuse {

std::vector<FrameIdx> CoarseFrames(std::span<const TrackedFrame> path,
                                   const Ground& ground,
                                   const FrameChoice& choice) {
  std::vector<TrackedFrame> of_one_world;
  for (const TrackedFrame& frame : path) {
    if (ApartAt(ground, frame.frame) == nullptr) of_one_world.push_back(frame);
  }
  return FramesToFuse(of_one_world, choice);
}

Result<CoarseSurface> FuseCoarse(const CoarseInputs& inputs,
                                 std::span<const FrameIdx> wanted,
                                 const CoarseOptions& options,
                                 Progress& progress) {
  CoarseFusion fusion(options);
  const auto integrate = [&](const Frame& frame) {
    const TrackedFrame& placed = inputs.path[static_cast<std::size_t>(frame.idx.value)];
    return fusion.Integrate(
        frame, inputs.frames.camera(), inputs.level_from_tracking * placed.world_from_camera);
  };
  if (Status status = ForFrames(inputs.frames, wanted, progress, integrate, FrameContent::kDepth);
      !status.ok())
    return status.error();
  if (fusion.surface_full()) {
    progress.Warn(
        "the capture outgrows layout.surface.max_voxel_blocks: what lies beyond is left out");
  }
  CoarseSurface surface = std::move(fusion).Take();
  surface.level_from_tracking = inputs.level_from_tracking;
  surface.has_ground = inputs.has_ground;
  return surface;
}

}  // namespace deepslam::fuse
