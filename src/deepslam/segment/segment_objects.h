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
  // Height above the ground below which a pixel is ground, close to the camera: the plane and the
  // floor differ by as much.
  static constexpr double kMinHeight_m = 0.03;
  // And this times the squared depth, as the depth noise of structured light grows.
  static constexpr double kHeight_per_m2 = 0.006;
  // Neighbouring pixels with a larger step in depth are not connected, close to the camera.
  static constexpr double kJump_m = 0.03;
  // And this times the squared depth, four deviations of a Kinect (Khoshelham and Elberink 2012:
  // 2.85 mm per m^2).
  static constexpr double kJump_per_m2 = 0.012;
  // Parts whose gap in space is smaller belong together: slats, legs.
  static constexpr double kJoin_m = 0.12;
  // Gaps without depth up to this width between measured parts of an object belong to its mask.
  static constexpr double kFillGap_m = 0.15;
  double min_piece_share =
      0.6;  // a surface belongs to a box that holds at least this share of its pixels
  double mask_dilation_px = 4;  // an instance mask is widened by this before it cuts
  static constexpr double kBorderMargin_px = 8;  // a box nearer to the image border touches it
  int min_points = 400;                          // fewer pixels: not usable
  static constexpr double kMinBoxShare = 0.04;   // smaller share of the box: not usable
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
