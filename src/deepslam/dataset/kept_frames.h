// Frames that are looked at again and again stay decoded.
//
// A run reads every frame once to track it, and its keyframes in most stages after that. An image
// (colour or depth) stays in memory from the second time it is asked for, or from when it is given
// back, until the memory given is full; what is kept then stays, since stages go through their
// frames in turn, and of a turn the oldest is needed next. Where images find no room any more depth
// is packed (packed_depth.h), first what is kept already.
#pragma once

#include <cstddef>
#include <memory>

#include "deepslam/frames/frame_source.h"

namespace deepslam::dataset {

// Equal frames and equal errors, thread-safe as `frames` is. `depth_units_per_m`: of the capture
// (CaptureCameras).
[[nodiscard]] std::unique_ptr<FrameSource> KeepFrames(std::unique_ptr<FrameSource> frames,
                                                      double depth_units_per_m,
                                                      std::size_t max_bytes);

}  // namespace deepslam::dataset
