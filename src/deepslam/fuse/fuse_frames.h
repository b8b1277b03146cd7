// The measured surface of the frames of a path, with or without the pixels of objects.
#pragma once

#include <span>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/fuse/object_masks.h"
#include "deepslam/fuse/tsdf.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::fuse {

// All outlive the call.
struct FusionInputs {
  const FrameSource& frames;
  std::span<const TrackedFrame> path;  // of each frame of the source
  const ObjectMasks& left_out;         // of the frames' size
};

// TsdfFusion of these frames in their order. A frame that cannot be read is warned about and left
// out. Errors: those of the fusion, and Interrupted.
[[nodiscard]] Result<TriangleMesh> FuseFrames(const FusionInputs& inputs,
                                              std::span<const FrameIdx> wanted,
                                              const FuseOptions& options,
                                              Progress& progress);

}  // namespace deepslam::fuse
