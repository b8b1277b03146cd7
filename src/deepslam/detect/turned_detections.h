// Detectors know furniture that stands: pictures that lie on their side or upside down are shown to
// them upright.
#pragma once

#include <vector>

#include "deepslam/core/quarter_turn.h"
#include "deepslam/core/result.h"
#include "deepslam/detect/detector.h"

namespace deepslam::detect {

// What the detector finds in the turned picture, boxes and masks back in the picture as it came.
[[nodiscard]] Result<std::vector<RawDetection>> DetectTurned(const Detector& detector,
                                                             const ColourImage& image,
                                                             QuarterTurn upright);

}  // namespace deepslam::detect
