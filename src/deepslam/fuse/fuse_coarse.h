// The coarse surface of the frames of a path.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/fuse/choose_frames.h"
#include "deepslam/fuse/coarse_fusion.h"
#include "deepslam/scene/coarse_surface.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::fuse {

// Of the frames whose place in the world of the first keyframe was measured, those that see
// something new.
[[nodiscard]] std::vector<FrameIdx> CoarseFrames(std::span<const TrackedFrame> path,
                                                 const Ground& ground,
                                                 const FrameChoice& choice);

// All outlive the call.
struct CoarseInputs {
  const FrameSource& frames;
  std::span<const TrackedFrame> path;  // of each frame of the source, tracking world
  Pose3 level_from_tracking;
  bool has_ground = false;
};

// CoarseFusion of the depth of these frames in their order. A frame that cannot be read is warned
// about and left out, and so is what outgrows options.max_voxel_blocks. Errors: those of the
// fusion, and Interrupted.
[[nodiscard]] Result<CoarseSurface> FuseCoarse(const CoarseInputs& inputs,
                                               std::span<const FrameIdx> wanted,
                                               const CoarseOptions& options,
                                               Progress& progress);

}  // namespace deepslam::fuse
