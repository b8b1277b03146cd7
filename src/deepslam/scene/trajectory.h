// Camera poses over time, and the relative-pose measurements between keyframes.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/geometry/symmetric_matrix6.h"

namespace deepslam {

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

// Measurements that lie elsewhere than in memory.
class ShelvedEdges {
 public:
  virtual ~ShelvedEdges() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  // Those from `first` on, as many as there is place for. Thread-safe. One that the machine does
  // not give joins no frames (its ids are not valid), and whoever keeps the shelf knows of it.
  virtual void Read(std::size_t first, std::span<RelativePose> edges) const = 0;
};

// One after the other, in their order.
void ForEach(const ShelvedEdges& edges, const std::function<void(const RelativePose&)>& use);

// A trajectory and what it was measured by, which is by far the larger part of it: a long path does
// not hold all of that.
struct Odometry : Trajectory {
  std::vector<RelativePose> edges;  // between keyframes; consecutive ones always joined
  std::shared_ptr<const ShelvedEdges> more_edges;  // behind `edges`; none: these are all

  [[nodiscard]] std::size_t num_edges() const {
    return edges.size() + (more_edges ? more_edges->size() : 0);
  }
  void ForEachEdge(const std::function<void(const RelativePose&)>& use) const;
};

}  // namespace deepslam
