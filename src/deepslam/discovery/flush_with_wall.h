// What lies in the face of a wall and is no piece of furniture: posters and
// pictures, which detectors take for televisions and clocks.
#pragma once

#include <vector>

#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::discovery {

struct HungThings {
  const FrameSource& frames;
  const Trajectory& trajectory;
  const Layout& layout;
  const ClassTable& classes;
  const std::vector<Segment>& segments;  // of the tracks' members, with masks
};

// Takes tracks of classes that may hang on a wall out of the association where most of what was
// measured of them stands out of a wall by no more than its noise; their detections become
// rejections, and `not_mapped` names them. A frame that cannot be read says nothing.
void LeaveOutFlush(const HungThings& things, Association& association);

}  // namespace deepslam::discovery
