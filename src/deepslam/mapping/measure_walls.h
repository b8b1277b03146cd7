// Walls of a layout in the depth of single keyframes: planes for the graph (graph/object_graph.h).
#pragma once

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/graph/wall_view.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::mapping {

struct WallViewOptions {
  int step_px = 4;               // between the pixels that are looked at
  double max_depth_m = 5;        // beyond, a depth camera's steps are larger than walls are apart
  double max_distance_m = 0.12;  // of a point from the wall as the path has it: walls and their
                                 // neighbours differ by more
  double max_angle_deg = 20;     // of the surface at a point, and half of that of the plane
  double on_plane_m = 0.03;      // points within are fitted, and three deviations of depth
  double min_extent_m = 0.4;     // along the wall and up it: a strip says nothing of a plane
  int min_points = 150;
};

// The planes of `layout`'s walls, and each keyframe's own of the walls that it saw, found where the
// path has them: drift of more than `max_distance_m` is not bridged. Keyframes that cannot be read
// take no part, with a warning. Errors: Interrupted.
[[nodiscard]] Result<graph::WallViews> MeasureWalls(const FrameSource& frames,
                                                    const Trajectory& trajectory,
                                                    const Layout& layout,
                                                    const WallViewOptions& options,
                                                    Progress& progress);

}  // namespace deepslam::mapping
