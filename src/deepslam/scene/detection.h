// Boxes found in colour images, and the pixels that belong to them.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/frames/pixel_mask.h"
#include "deepslam/geometry/box.h"

namespace deepslam {

enum class DetectionSource {
  kNetwork,  // a detector network on the colour image
  kFile,     // a user's COCO file
  kCluster,  // a floor-standing depth cluster that no other detection has found; its class is a
             // guess by its size
};

struct Detection {
  DetectionId id;
  FrameIdx frame;
  std::string class_name;  // of the class table ("chair"), not the detector's own label
  double score = 0;        // [0, 1]
  Box2 box_px;             // clipped to the image
  DetectionSource source = DetectionSource::kNetwork;
  // Instance mask of the whole image where the source gave one; empty otherwise.
  PixelMask mask;
};

// The pixels of one detection that are the object: near enough, off the ground, connected; where
// the sensor measured nothing, what lies between measured parts of the object.
struct Segment {
  DetectionId detection;
  FrameIdx frame;
  std::string class_name;
  double score = 0;  // this, source and box are the detection's
  DetectionSource source = DetectionSource::kNetwork;
  Box2 box_px;
  PixelMask mask;               // size of the image; 1 = object, with or without depth
  int num_points = 0;           // pixels of the mask with depth
  Box3 extent_camera;           // of the segment's points, metres
  double depth_support = 0;     // num_points / box pixels
  bool touches_border = false;  // box within the border margin: may match, but starts no object
  bool usable = false;          // enough points to go on with
  std::string reason;           // why not usable
};

}  // namespace deepslam
