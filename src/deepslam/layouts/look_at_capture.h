// Frames of a capture looked at when it is opened, for what is hardly meant (dataset/doubts.h,
// picture_alignment.h) and for poses that contradict the depth (pose_readings.h).
#pragma once

#include <string>
#include <vector>

#include "deepslam/dataset/capture.h"

namespace deepslam::layouts {

// Of its camera, times, depth and of colour against depth.
[[nodiscard]] std::vector<std::string> DoubtsOf(const dataset::Capture& capture);

// What is wrong with poses that leave the surfaces of frames apart, and which other reading of
// `poses_file` would not; empty where they fit, or where it cannot be told.
[[nodiscard]] std::string FaultOfPoses(const dataset::Capture& capture,
                                       const std::string& poses_file);

}  // namespace deepslam::layouts
