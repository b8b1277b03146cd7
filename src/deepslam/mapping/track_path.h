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

// The poses that came with the capture are not looked at (kNone), or are where tracking starts,
// what it goes on by where it is lost, and weak edges of the graph (kAsPrior; recorded_edges.h).
enum class RecordedPath { kNone, kAsPrior };

// Errors are those of EstimateOdometry and RefinePath, and InvalidInput where poses are a prior and
// the capture has none.
[[nodiscard]] Result<TrackedPath> TrackPath(const FrameSource& frames,
                                            const tracking::OdometryOptions& options,
                                            const loop::CovisibleOptions& covisible,
                                            const EdgeStoreFactory& new_store,
                                            Progress& progress,
                                            RecordedPath recorded = RecordedPath::kNone);

// By the poses that came with the capture, which are not refined. Errors are those of
// OdometryFromCapturePoses.
[[nodiscard]] Result<TrackedPath> TakePathOfCapture(const FrameSource& frames,
                                                    const tracking::OdometryOptions& options,
                                                    Progress& progress);

}  // namespace deepslam::mapping
