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

// Clusters of the turned depth, as they lie in the turned picture.
struct UprightClusters {
  QuarterTurn upright = QuarterTurn::kNone;
  int width = 0;  // of the picture as it came
  int height = 0;
  FrameClusters found;
};

// FindClusters on the turned depth; frame, camera and ground are of the picture as it came.
[[nodiscard]] UprightClusters FindClustersTurned(const Frame& frame,
                                                 const PinholeCamera& camera,
                                                 const Plane& ground_camera,
                                                 const ClassTable& classes,
                                                 const ClusterOptions& options,
                                                 QuarterTurn upright);

// Those that `covered` does not explain; everything given and returned is of the picture as it
// came.
[[nodiscard]] std::vector<Detection> UncoveredTurned(UprightClusters clusters,
                                                     std::span<const Detection> covered);

}  // namespace deepslam::detect
