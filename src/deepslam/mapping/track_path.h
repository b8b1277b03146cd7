// The path of a capture: tracked, and refined by keyframes that see the same.
#pragma once

#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/loop/covisible.h"
#include "deepslam/scene/edge_store.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/tracking/odometry.h"

namespace deepslam::mapping {

struct TrackedPath {
  Odometry odometry;
  std::vector<Pose3> world_from_camera_as_tracked;  // of each frame, before the path was refined
};

// Errors are those of EstimateOdometry and RefinePath.
[[nodiscard]] Result<TrackedPath> TrackPath(const FrameSource& frames,
                                            const tracking::OdometryOptions& options,
                                            const loop::CovisibleOptions& covisible,
                                            const EdgeStoreFactory& new_store,
                                            Progress& progress);

// By the poses that came with the capture, which are not refined. Errors are those of
// OdometryFromCapturePoses.
[[nodiscard]] Result<TrackedPath> TakePathOfCapture(const FrameSource& frames,
                                                    const tracking::OdometryOptions& options,
                                                    Progress& progress);

}  // namespace deepslam::mapping
