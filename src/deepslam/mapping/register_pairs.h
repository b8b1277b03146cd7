// Pairs of keyframes aligned with each other, whoever proposed them: neighbours that see the same,
// places that look alike.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/loop/appearance.h"
#include "deepslam/mapping/keyframe_pyramids.h"

namespace deepslam::mapping {

struct KeyframePair {
  FrameIdx older;
  FrameIdx newer;
  Pose3 older_from_newer;  // where the alignment starts
};

struct PairAlignment {
  std::function<alignment::FrameAlignment(const alignment::FramePyramid& older,
                                          const alignment::FramePyramid& newer,
                                          const Pose3& start)>
      align;
  std::size_t pairs_at_once = 16;
  std::string_view without;  // what a keyframe that cannot be read goes without, for the warning
};

// One for each pair, in their order; not ok where a keyframe cannot be read, of which a warning
// tells. Interrupted when asked to stop.
[[nodiscard]] Result<std::vector<loop::KeyframeRegistration>> RegisterPairs(
    KeyframePyramids& pyramids,
    std::span<const KeyframePair> pairs,
    const PairAlignment& alignment,
    Progress& progress);

}  // namespace deepslam::mapping
