// What tracking may be asked for.
#pragma once

#include <string>

#include "deepslam/alignment/alignment_options.h"
#include "deepslam/core/options.h"

namespace deepslam::tracking {

struct OdometryOptions {
  alignment::AlignmentOptions alignment;
  std::string reference = "keyframe";  // "keyframe" or "previous": what a frame is aligned to
  bool motion_prediction = true;       // constant velocity as one of the starts
  bool rotation_search = true;  // image-based rotation as one of the starts: survives fast turns
  double keyframe_distance_m = 0.10;      // a new keyframe beyond this distance ...
  double keyframe_angle_deg = 8;          // ... or this angle from the current one ...
  double keyframe_min_overlap = 0.65;     // ... or below this overlap with it
  int num_relocalisation_keyframes = 12;  // last keyframes kept to find the way back after a loss
  // A frame with a smaller share of pixels with usable depth is not aligned: a lens that is
  // covered, or a wall nearer than the sensor measures.
  static constexpr double kMinValidShare = 0.03;
  // Standard deviations behind the edges that carry a lost frame, and those of poses that came with
  // the capture.
  double lost_translation_m = 0.5;
  double lost_rotation_deg = 30;
  double capture_translation_m = 0.01;
  double capture_rotation_deg = 0.5;
};

void Describe(OptionsVisitor& visitor, OdometryOptions& options);

}  // namespace deepslam::tracking
