// One view of one object: everything later stages need of the frame, cut out around the detection's
// box.
#pragma once

#include <optional>

#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"
#include "deepslam/core/quarter_turn.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"

namespace deepslam {

struct ObjectView {
  DetectionId detection;
  FrameIdx frame;
  double detection_score = 0;
  bool touches_border = false;
  // The crop's pixel (0, 0) is the image's pixel (u0, v0); all crops have the same size. The crop
  // is the detection's box widened by a margin, so that free space around the object is in it too.
  int u0 = 0;
  int v0 = 0;
  ColourImage colour_crop;
  DepthImage depth_crop_m;  // all depth, not the object's alone; 0 = invalid
  Mask mask_crop;           // 1 = the object's segment, where it has depth
  PinholeCamera
      camera;  // of the crop: principal point moved by (u0, v0), width and height of the crop
  Pose3 world_from_camera;  // tracking world
  std::optional<Plane>
      ground_camera;  // ground in this camera, normal up; nothing when no ground is known
  QuarterTurn upright = QuarterTurn::kNone;  // sets the image upright where no ground is known
};

}  // namespace deepslam
