// Camera poses over time, and the relative-pose measurements between keyframes.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/geometry/symmetric_matrix6.h"

namespace deepslam {

class EdgeStore;

enum class TrackingStatus {
  kTracked,     // aligned, all six directions constrained
  kDegenerate,  // aligned, but at least one direction is weakly constrained (flat wall, corridor)
  kLost,        // alignment failed; the pose is a prediction and the edge that carries it has low
                // information
  kUnreadable,  // the frame's images could not be used; the pose is a prediction
};

// One entry per frame of the capture, in frame order.
struct TrackedFrame {
  FrameIdx frame;
  double time_s = 0;
  Pose3 world_from_camera;  // tracking world: camera of the first usable frame = identity (before
                            // `optimize`)
  TrackingStatus status = TrackingStatus::kTracked;
  FrameIdx keyframe;        // keyframe this frame was tracked against; its own idx for a keyframe
  double rmse_m = 0;        // point-to-plane rmse over inliers
  double inlier_share = 0;  // inliers / valid source points
};

// Whether the frame's pose was measured.
[[nodiscard]] inline bool IsAligned(const TrackedFrame& frame) {
  return frame.status == TrackingStatus::kTracked || frame.status == TrackingStatus::kDegenerate;
}

// A measurement i_from_j between two keyframes: T_ij maps points of camera j to camera i.
struct RelativePose {
  FrameIdx i;
  FrameIdx j;
  Pose3 i_from_j;
  // Information of t2v(measured^-1 * true) in (translation m; rotation rad) order; positive
  // definite.
  SymmetricMatrix6d information = Matrix6d::Identity();
  bool composed = false;  // chained from frame-to-frame poses because the direct alignment failed
};

struct Trajectory {
  std::vector<TrackedFrame> frames;
  std::vector<FrameIdx> keyframes;  // ascending

  [[nodiscard]] const TrackedFrame& at(FrameIdx frame) const {
    return frames[static_cast<std::size_t>(frame.value)];
  }
};

// A trajectory and what it was measured by, which is by far the larger part of it: a long path does
// not hold all of that.
struct Odometry : Trajectory {
  std::vector<RelativePose> edges;  // between keyframes; consecutive ones always joined
  // Behind `edges`, where they are too many to be held (edge_store.h); none: these are all.
  std::shared_ptr<const EdgeStore> more_edges;

  [[nodiscard]] std::size_t num_edges() const;
  void ForEachEdge(const std::function<void(const RelativePose&)>& use) const;
};

}  // namespace deepslam
