// Plots as inline SVG, made from values alone: same values, same text.
#pragma once

#include <span>
#include <string>

#include "deepslam/report/report_content.h"

namespace deepslam::report {

// The floor plan, and on it the camera path coloured by status (green tracked, orange degenerate,
// red lost), keyframes, and the path before the graph as a grey line.
[[nodiscard]] std::string PlanWithPath(const ReportContent& content);

// Height of the camera above the ground over the frames, m, with the frames' status underneath.
[[nodiscard]] std::string HeightOverTime(std::span<const TrackedFrame> frames);

// Camera height of the trajectory minus the height read off the floor in the same keyframe, cm:
// grey before the graph, blue after. A flat line at zero is a trajectory without vertical drift.
[[nodiscard]] std::string HeightDrift(std::span<const HeightCheck> heights, int num_frames);

// How far the graph moved each frame, cm. Frames after that one are all moved by a drift that was
// taken out.
[[nodiscard]] std::string GraphCorrection(std::span<const TrackedFrame> frames,
                                          std::span<const Pose3> tracked_world_from_camera);

}  // namespace deepslam::report
