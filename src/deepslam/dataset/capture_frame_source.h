// Frames for the stages from a capture as it is stored: decoded, in metres, depth registered to
// colour.
#pragma once

#include <memory>

#include "deepslam/dataset/read_faults.h"
#include "deepslam/dataset/stored_frames.h"
#include "deepslam/frames/frame_source.h"

namespace deepslam::dataset {

// A frame's time is that of its depth image, since depth is what is tracked; its camera is that of
// colour, reduced when depth is coarser (depth_registration.h). Depth is in metres by MetresOfRaw
// (frames/raw_depth.h). Faults of the machine are noted in `faults`, where there is one.
std::unique_ptr<FrameSource> MakeCaptureFrameSource(std::shared_ptr<const StoredFrames> stored,
                                                    std::shared_ptr<ReadFaults> faults = nullptr);

}  // namespace deepslam::dataset
