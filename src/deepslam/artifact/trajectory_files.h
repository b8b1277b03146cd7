// Trajectories: poses as TUM text (opened by evo and others), everything TUM cannot hold in
// frames.json beside it.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/measured_parts.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::artifact {

struct StampedPose {
  double time_s = 0;
  Pose3 world_from_camera;
};

// Lines "time tx ty tz qx qy qz qw"; numbers read back exactly.
[[nodiscard]] Result<std::string> EncodeTum(std::span<const StampedPose> poses,
                                            std::string_view name);
// Comments (#) and empty lines are skipped; a fault names the line. Quaternions far from unit
// length are refused.
[[nodiscard]] Result<std::vector<StampedPose>> DecodeTum(TextSource text, std::string_view name);

[[nodiscard]] std::vector<StampedPose> StampedPoses(std::span<const TrackedFrame> frames);
[[nodiscard]] std::vector<StampedPose> KeyframePoses(std::span<const TrackedFrame> frames,
                                                     std::span<const FrameIdx> keyframes);

// frames.json: per frame index, status, keyframe, rmse, inlier share; the list of keyframes;
// composed ones of the joins as [i, j].
[[nodiscard]] Result<std::string> EncodeFrames(std::span<const TrackedFrame> frames,
                                               std::span<const FrameIdx> keyframes,
                                               std::span<const KeyframeJoin> joins,
                                               std::string_view name);

// Joins both texts: line n of the TUM text is the pose of entry n of frames.json; differing counts
// or times are refused.
[[nodiscard]] Result<Trajectory> DecodeTrajectory(TextSource frames_json,
                                                  TextSource tum_text,
                                                  std::string_view name);
// All of a tracking result: the same, and behind it the edges of a g2o text, whose `composed` flags
// come from frames.json; those that join other frames than there are are refused.
struct OdometryTexts {
  TextSource frames_json;
  TextSource tum;
  TextSource g2o;
  std::string_view name;  // of frames.json, for messages
  std::string_view g2o_name;
};
[[nodiscard]] Result<Trajectory> DecodeOdometry(OdometryTexts texts, const EdgeSink& take);

}  // namespace deepslam::artifact
