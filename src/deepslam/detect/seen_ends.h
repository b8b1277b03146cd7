// Whether a cluster is seen to end: furniture does, what runs on out of view may be anything.
#pragma once

#include "deepslam/detect/cluster_detector.h"
#include "deepslam/detect/ground_clusters.h"
#include "deepslam/detect/ground_grid.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"

namespace deepslam::detect {

// Share of the outline towards the camera in front of which floor is seen: 1 for a thing that
// stands free.
[[nodiscard]] double FreeShare(const GroundGrid& grid,
                               const Components& components,
                               const Cluster& cluster);

// Whether both its left and its right end are seen to end in enough rows of the image: next to them
// lies floor, a wall or something farther. A thing that runs on behind an occluder, out of the
// picture or into missing depth does not.
[[nodiscard]] bool EndsAreSeen(const Frame& frame,
                               const PinholeCamera& camera,
                               const Plane& ground_camera,
                               const Mask& wall,
                               const Cluster& cluster);

}  // namespace deepslam::detect
