// Frames for the stages from a capture as it is stored: decoded, in metres, depth registered to
// colour.
#pragma once

#include <memory>

#include "deepslam/dataset/read_faults.h"
#include "deepslam/dataset/stored_frames.h"
#include "deepslam/scene/frame_source.h"

namespace deepslam::dataset {

// A frame's time is that of its depth image, since depth is what is tracked; its camera is that of
// colour, reduced when depth is coarser (depth_registration.h). Depth 0, 65535 (saturated) and
// beyond kMaxDepthM is invalid.
// Faults of the machine are noted in `faults`, where there is one.
std::unique_ptr<FrameSource> MakeCaptureFrameSource(std::shared_ptr<const StoredFrames> stored,
                                                    std::shared_ptr<ReadFaults> faults = nullptr);

// Raw depth in metres by the rule above.
[[nodiscard]] DepthImage ToMetres(const RawDepthImage& raw, double depth_units_per_m);

}  // namespace deepslam::dataset
