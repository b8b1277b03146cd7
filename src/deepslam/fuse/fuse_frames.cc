#include "deepslam/fuse/fuse_frames.h"

#include <utility>

#include "deepslam/frames/for_frames.h"

namespace deepslam::fuse {
Result<TriangleMesh> FuseFrames(const FusionInputs& inputs,
                                std::span<const FrameIdx> wanted,
                                const FuseOptions& options,
                                Progress& progress) {
  TsdfFusion fusion(options);
  const auto integrate = [&](const Frame& frame) -> Status {
    const Mask objects = ObjectPixels(inputs.left_out, frame.idx);
    const TrackedFrame& placed = inputs.path[static_cast<std::size_t>(frame.idx.value)];
    return fusion.Integrate(frame,
                            inputs.frames.camera(),
                            placed.world_from_camera,
                            objects.empty() ? nullptr : &objects);
  };
  if (Status status = ForFrames(inputs.frames, wanted, progress, integrate); !status.ok())
    return status.error();
  return std::move(fusion).TakeMesh();
}

}  // namespace deepslam::fuse
