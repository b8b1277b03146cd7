// The camera's path before the graph, against the final one.
#pragma once

#include <vector>

#include "deepslam/geometry/pose.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::report {

struct TrackedPath {
  std::vector<Pose3> world_from_camera;  // laid onto the first final pose; one per frame, or none
  std::vector<HeightCheck> heights;      // ascending frames; empty without a ground
};

// Nothing where the two paths are not of the same frames.
[[nodiscard]] TrackedPath LayOntoMap(const Trajectory& tracked,
                                     const Ground& ground,
                                     const OptimizedMap& map);

}  // namespace deepslam::report
