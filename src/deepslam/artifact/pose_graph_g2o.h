// Pose graphs as g2o text. g2o's EDGE_SE3:QUAT measures rotation errors by the quaternion's vector
// part, half the rotation vector for small angles; information is converted when writing and
// reading (rotation rows and columns times two per side), so that the file's chi^2 by g2o's
// convention is the program's own to first order.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::artifact {

// Vertices: the keyframes' poses (ids are frame indices), the first one fixed. Edges: `i j` with
// i_from_j.
[[nodiscard]] Result<std::string> EncodeG2o(std::span<const TrackedFrame> frames,
                                            std::span<const FrameIdx> keyframes,
                                            std::span<const RelativePose> edges,
                                            std::string_view name);

// The EDGE_SE3:QUAT lines, information converted back; other known tags are skipped. A fault names
// the line. The `composed` flag is not in the file.
[[nodiscard]] Result<std::vector<RelativePose>> DecodeG2oEdges(std::string_view text,
                                                               std::string_view name);

}  // namespace deepslam::artifact
