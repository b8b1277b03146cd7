// Detectors know furniture that stands, and clusters are told by what ends them to the left and the
// right: pictures that lie on their side or upside down are shown to both upright.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/quarter_turn.h"
#include "deepslam/core/result.h"
#include "deepslam/detect/cluster_detector.h"
#include "deepslam/detect/detector.h"

namespace deepslam::detect {

// What the detector finds in the turned picture, boxes and masks back in the picture as it came.
[[nodiscard]] Result<std::vector<RawDetection>> DetectTurned(const Detector& detector,
                                                             const ColourImage& image,
                                                             QuarterTurn upright);

// DetectClusters on the turned depth; everything given and found is of the picture as it came.
[[nodiscard]] std::vector<Detection> DetectClustersTurned(const Frame& frame,
                                                          const PinholeCamera& camera,
                                                          const Plane& ground_camera,
                                                          std::span<const Detection> covered,
                                                          const ClassTable& classes,
                                                          const ClusterOptions& options,
                                                          QuarterTurn upright);

}  // namespace deepslam::detect
