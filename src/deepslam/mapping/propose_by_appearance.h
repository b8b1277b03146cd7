// Keyframes of a path looked at once, for places that look alike (loop/appearance.h) and for
// adjacent keyframes that tracking measured poorly (loop/neighbours.h).
#pragma once

#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/loop/appearance.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::mapping {

// To be registered. In the tracking world.
struct AppearanceProposals {
  std::vector<AppearanceLoop> loops;     // in the order of the new keyframes
  std::vector<AppearanceLoop> adjacent;  // in the order of the older keyframes
};

// `by_depth_alone`: tracking used no colour, so that all its measurements are poor. Keyframes that
// cannot be read take no part, with a warning. Features of the looked at keyframes are held until
// the end, of the others for a few dozen keyframes. The error is Interrupted.
[[nodiscard]] Result<AppearanceProposals> ProposeByAppearance(
    const FrameSource& frames,
    const Odometry& odometry,
    bool by_depth_alone,
    const loop::AppearanceOptions& options,
    Progress& progress);

}  // namespace deepslam::mapping
