// Frames of a source one after another, read ahead of need.
#pragma once

#include <functional>
#include <span>

#include "deepslam/core/ids.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"

namespace deepslam {

// What is read of a frame: depth alone where colour is not needed, which is half of its time.
enum class FrameContent { kColourAndDepth, kDepth };

// Reads frames in parallel, a few at a time, and hands each to `use` in the order given, with
// progress. A frame that cannot be read is warned about and skipped. Ends with the first error of
// `use`, and with Interrupted when asked to stop.
[[nodiscard]] Status ForFrames(const FrameSource& frames,
                               std::span<const FrameIdx> wanted,
                               Progress& progress,
                               const std::function<Status(const Frame&)>& use,
                               FrameContent content = FrameContent::kColourAndDepth);

}  // namespace deepslam
