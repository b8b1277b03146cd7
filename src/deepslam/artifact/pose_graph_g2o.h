// Pose graphs as g2o text. g2o's EDGE_SE3:QUAT measures rotation errors by the quaternion's vector
// part, half the rotation vector for small angles; information is converted when writing and
// reading (rotation rows and columns times two per side), so that the file's chi^2 by g2o's
// convention is the program's own to first order.
#pragma once

#include <functional>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::artifact {

// Vertices: the keyframes' poses (ids are frame indices), the first one fixed. Edges: `i j` with
// i_from_j. In pieces of some edges each: a capture of an hour has a hundred megabytes of them.
[[nodiscard]] Status EncodeG2o(const Odometry& odometry,
                               std::string_view name,
                               const TextSink& sink);

// Takes edges in their order; an error ends the text.
using EdgeSink = std::function<Status(const RelativePose& edge)>;

// The EDGE_SE3:QUAT lines, information converted back; other known tags are skipped. The `composed`
// flag is not in the file. A fault names the line.
[[nodiscard]] Status DecodeG2oEdges(TextSource text, std::string_view name, const EdgeSink& take);

}  // namespace deepslam::artifact
