// The three texts of a tracking result together: frames.json, trajectory.tum and odometry.g2o,
// separated by lines that begin with "%".
#include <array>
#include <string_view>

#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/trajectory_files.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(odometry) {
  std::array<std::string_view, 3> texts;
  for (std::string_view& text : texts) {
    const std::size_t end = bytes.find("\n%");
    text = bytes.substr(0, end);
    bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 2);
  }
  Odometry odometry;
  const auto take = [&](const RelativePose& edge) {
    odometry.edges.push_back(edge);
    return Ok();
  };
  const Result<Trajectory> trajectory =
      artifact::DecodeOdometry({texts[0], texts[1], texts[2], kFile, kFile}, take);
  if (!trajectory.ok()) return Refused(trajectory.error());
  for (const RelativePose& edge : odometry.edges) {
    DEEPSLAM_CHECK(edge.i.value < static_cast<int>(trajectory->frames.size()) &&
                       edge.j.value < static_cast<int>(trajectory->frames.size()),
                   "edges join frames");
  }
  const auto text =
      artifact::EncodeFrames(trajectory->frames, trajectory->keyframes, JoinsOf(odometry), kFile);
  DEEPSLAM_CHECK(text.ok(), "what was read can be written");
  return true;
}
