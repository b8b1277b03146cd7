// Silhouettes: which pixels of a detection's box are the object.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/core/quarter_turn.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::segment {

struct SegmentOptions {
  double max_depth_m = 5.0;  // farther depth is not used
  double min_height_m =
      0.03;  // height above the ground below which a pixel is ground, close to the camera ...
  double height_per_m2 =
      0.006;  // ... plus this times the squared depth (depth noise of structured light grows so)
  double jump_m = 0.03;        // neighbouring pixels with a larger depth step are not connected ...
  double jump_per_m2 = 0.012;  // ... plus this times the squared depth
  double join_m = 0.12;        // parts whose gap in space is smaller belong together (slats, legs)
  // Gaps without depth up to this width between measured parts of an object belong to its mask.
  double fill_gap_m = 0.15;
  double min_piece_share =
      0.6;  // a surface belongs to a box that holds at least this share of its pixels
  double mask_dilation_px = 4;  // an instance mask is widened by this before it cuts
  double border_margin_px = 8;  // a box nearer to the image border touches it
  int min_points = 400;         // fewer pixels: not usable
  double min_support = 0.04;    // smaller share of the box: not usable
};
void Describe(OptionsVisitor& visitor, SegmentOptions& options);

struct FrameToSegment {
  const Frame& frame;
  const PinholeCamera& camera;
  std::optional<Plane> ground_camera;  // normal up; without it nothing is removed as ground
  std::span<const Detection> detections;
  QuarterTurn upright = QuarterTurn::kNone;  // what sets the image upright
};

// One segment per detection, in the order given; masks do not overlap. Detections without enough
// depth come back with usable = false and the reason. `classes` says which of them have a support
// plane.
[[nodiscard]] std::vector<Segment> SegmentFrame(const FrameToSegment& seen,
                                                const ClassTable& classes,
                                                const SegmentOptions& options);

}  // namespace deepslam::segment
