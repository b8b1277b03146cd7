// Pose graphs as g2o text. g2o's EDGE_SE3:QUAT measures rotation errors by the quaternion's vector
// part, half the rotation vector for small angles; information is converted when writing and
// reading (rotation rows and columns times two per side), so that the file's chi^2 by g2o's
// convention is the program's own to first order.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "deepslam/artifact/text_pieces.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::artifact {

// Vertices: the keyframes' poses (ids are frame indices), the first one fixed. Edges: `i j` with
// i_from_j. In pieces of some edges each: a capture of an hour has a hundred megabytes of them.
[[nodiscard]] Status EncodeG2o(std::span<const TrackedFrame> frames,
                               std::span<const FrameIdx> keyframes,
                               std::span<const RelativePose> edges,
                               std::string_view name,
                               const TextSink& sink);

// The EDGE_SE3:QUAT lines, information converted back; other known tags are skipped. The `composed`
// flag is not in the file.
class G2oEdgeReader {
 public:
  // `name` is the file's name for messages.
  explicit G2oEdgeReader(std::string_view name) : name_(name) {}

  // The next lines of the file, whole ones. A fault names the line.
  [[nodiscard]] Status Read(std::string_view lines);
  [[nodiscard]] std::vector<RelativePose> TakeEdges() { return std::move(edges_); }

 private:
  std::string name_;
  int line_number_ = 0;
  std::vector<RelativePose> edges_;
};

}  // namespace deepslam::artifact
