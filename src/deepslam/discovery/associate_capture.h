// Which pixels of which frames are the same object, over a whole capture: things found in the
// surface where there is one with its ground, the votes of detections (associate/associate.h)
// everywhere else.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "deepslam/associate/associate.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/discovery/find_things.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/layout.h"

namespace deepslam::discovery {

// The surface of the frames that were registered to the first keyframe, with its layout.
struct SurfaceOfCapture {
  CoarseSurface surface;
  Layout layout;
};

struct CaptureInputs {
  const FrameSource& frames;
  const Trajectory& trajectory;
  std::span<const int> part_of_frame;
  const Ground& ground;
  const ClassTable& classes;
  std::span<const FrameIdx> looked_at;    // by the detector, ascending
  std::span<const Detection> detections;  // of these frames
  // None: objects are found by votes alone, as in the paper.
  const std::optional<SurfaceOfCapture>& surface;
  const Layout& layout;  // what lies flush in its walls is no object
};

// `segments`: of the detections, by single frames, ascending. Frames that have no measured place in
// the surface's world go by votes. Errors: Interrupted only.
[[nodiscard]] Result<FoundThings> AssociateCapture(const CaptureInputs& inputs,
                                                   std::vector<Segment> segments,
                                                   const associate::AssociateOptions& by_votes,
                                                   const ThingOptions& by_surface,
                                                   Progress& progress);

}  // namespace deepslam::discovery
