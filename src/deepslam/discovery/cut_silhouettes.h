// Silhouettes of things with a support plane, cut by their frame's own depth: the surface of the
// capture says where a table is, the frame where its top and its legs end.
#pragma once

#include <span>
#include <vector>

#include "deepslam/frames/frame.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/instances/find_instances.h"
#include "deepslam/instances/silhouettes.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/segment/segment_objects.h"

namespace deepslam::discovery {

struct FrameOfThings {
  const Frame& frame;
  const PinholeCamera& camera;
  const Pose3& level_from_camera;
  std::span<const instances::Instance> things;
};

// Of a thing with a support plane the silhouette becomes the level layer within the thing's outline
// and what carries it, as stage `segment` finds them in the box of a detection. What stands on a
// table is then none of it and its legs are, though the surface of the capture is too coarse to
// tell. Silhouettes in which no such layer is found, and all others, stay as they are; masks do not
// overlap, as before.
void CutSilhouettes(const FrameOfThings& seen,
                    const ClassTable& classes,
                    const segment::SegmentOptions& options,
                    std::vector<instances::Silhouette>& silhouettes);

}  // namespace deepslam::discovery
