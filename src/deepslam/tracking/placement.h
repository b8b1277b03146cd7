// A frame aligned to a reference frame of the path, from wherever the camera may be, and accepted
// only where that can be its place.
#pragma once

#include <optional>
#include <vector>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/tracking/feature_starts.h"
#include "deepslam/tracking/keyframe_window.h"
#include "deepslam/tracking/motion_gate.h"
#include "deepslam/tracking/odometry_options.h"
#include "deepslam/tracking/posed_frame.h"

namespace deepslam::tracking {

// Alignments of real captures that are right have so many inliers among their overlapping points.
inline constexpr double kConfidentInlierRatio = 0.85;

// What frames are placed by: the path so far.
struct PathSoFar {
  const OdometryOptions& options;
  const KeyframeWindow& keyframes;
  const PosedFrame& previous;  // the frame placed last
  const MotionModel& motion;   // ... and how it came there
  const FeatureStarts* features = nullptr;
};

// World from the camera of a frame: moved since the frame placed last as the recorder says, where
// it says it of both, else carried on by constant velocity. Nothing where neither is known.
[[nodiscard]] std::optional<Pose3> PredictedPose(const PathSoFar& path, const PosedFrame& frame);
// The former alone.
[[nodiscard]] std::optional<Pose3> RecordedPose(const PosedFrame& previous,
                                                const PosedFrame& frame);

struct Starts {
  std::vector<Pose3> world_from_camera;     // the likeliest first; at least one
  const PosedFrame* turned_from = nullptr;  // whose image a turn is searched for in, if need be
};

// Where the camera is expected (PredictedPose), or was; and turned from there.
[[nodiscard]] Starts StartsBehindPrevious(const PathSoFar& path, const PosedFrame& frame);

// Successive images correlate like that where they are laid right, however poor their depth is;
// laid elsewhere, they differ by parallax.
inline constexpr double kSameImage = 0.95;

// Alignments of real captures that are right are: enough inliers and images that are alike, or
// images that are so alike that depth may be poor. False where it is not ok.
[[nodiscard]] bool IsConfident(const alignment::FrameAlignment& alignment);

// `frame` aligned to `reference` from starts in the world, and from another one in the world that
// `search` may find.
[[nodiscard]] alignment::FrameAlignment AlignTo(const PathSoFar& path,
                                                const PosedFrame& reference,
                                                const PosedFrame& frame,
                                                const std::vector<Pose3>& starts_world,
                                                const alignment::StartSearch& search = {});

// AlignTo. Not ok where it is not to be accepted (placement_acceptance.h) of a camera that was at
// `last` before.
[[nodiscard]] alignment::FrameAlignment Place(const PathSoFar& path,
                                              const PosedFrame& reference,
                                              const PosedFrame& last,
                                              const PosedFrame& frame,
                                              const Starts& starts);

// Place, from where points that the frame shares with the reference have it. Not ok where they are
// too few, and where it would join sub-trajectories: things look alike in other rooms.
[[nodiscard]] alignment::FrameAlignment PlaceByFeatures(const PathSoFar& path,
                                                        const PosedFrame& reference,
                                                        const PosedFrame& last,
                                                        const PosedFrame& frame);

}  // namespace deepslam::tracking
