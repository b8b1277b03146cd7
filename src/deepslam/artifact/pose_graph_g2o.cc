#include "deepslam/artifact/pose_graph_g2o.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/json_value.h"
#include "deepslam/core/text_numbers.h"

namespace deepslam::artifact {
namespace {

// Tag and two ids, pose, upper triangle of the information.
constexpr std::size_t kEdgeWords = 3 + 7 + 21;
// 256 KiB: what is held of a long graph while it is written.
constexpr std::size_t kPieceBytes = std::size_t{1} << 18;

void AppendPose(const Pose3& pose, std::string& text) {
  const Eigen::Vector4d q = pose.rotation.coeffs();
  const Eigen::Vector3d& t = pose.translation_m;
  for (const double value : {t[0], t[1], t[2], q[0], q[1], q[2], q[3]}) {
    text += ' ';
    text += ShortestDecimal(value);
  }
}

// rotation vector = 2 * quaternion vector part, so each rotation side of the information takes a
// factor 2 (exact).
Matrix6d ScaleRotation(const Matrix6d& information, double factor) {
  Matrix6d scaled = information;
  scaled.bottomRows<3>() *= factor;
  scaled.rightCols<3>() *= factor;
  return scaled;
}

Status AppendEdge(const RelativePose& edge, std::string_view name, std::string& text) {
  if (!edge.information.Full().allFinite() || !edge.i_from_j.translation_m.allFinite() ||
      !edge.i_from_j.rotation.coeffs().allFinite()) {
    return Failed(fmt::format("{}: edge {} -> {} is not finite", name, edge.i.value, edge.j.value));
  }
  text += fmt::format("EDGE_SE3:QUAT {} {}", edge.i.value, edge.j.value);
  AppendPose(edge.i_from_j, text);
  const Matrix6d information = ScaleRotation(edge.information.Full(), 2.0);
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) {
      text += ' ';
      text += ShortestDecimal(information(row, col));
    }
  }
  text += '\n';
  return Ok();
}

Result<RelativePose> DecodeEdge(std::span<const std::string_view> words) {
  if (words.size() != kEdgeWords) {
    return InvalidInput(
        fmt::format("has {} words, an EDGE_SE3:QUAT has {}", words.size(), kEdgeWords));
  }
  RelativePose edge;
  const std::optional<int> i = ParseInt(words[1]);
  const std::optional<int> j = ParseInt(words[2]);
  if (!i || !j || *i < 0 || *j < 0)
    return InvalidInput("needs two vertex ids that are not negative");
  edge.i = FrameIdx{*i};
  edge.j = FrameIdx{*j};
  std::vector<double> n;
  for (const std::string_view word : words.subspan(3)) {
    const std::optional<double> number = ParseNumber(word);
    if (!number) return InvalidInput(fmt::format("\"{}\" is not a finite number", word));
    n.push_back(*number);
  }
  edge.i_from_j = {Eigen::Quaterniond(n[6], n[3], n[4], n[5]), {n[0], n[1], n[2]}};
  const double norm = edge.i_from_j.rotation.norm();
  if (std::abs(norm - 1) > 0.01)
    return InvalidInput(fmt::format("quaternion has norm {}, must be 1", norm));
  if (std::abs(norm - 1) > 1e-9) edge.i_from_j.rotation.normalize();
  Matrix6d information;
  std::size_t at = 7;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) information(row, col) = information(col, row) = n[at++];
  }
  edge.information = ScaleRotation(information, 0.5);
  return edge;
}

}  // namespace

Status EncodeG2o(const Odometry& odometry, std::string_view name, const TextSink& sink) {
  std::string text;
  const auto pass_on = [&](std::size_t most_bytes) {
    if (text.size() <= most_bytes) return Ok();
    Status status = sink(text);
    text.clear();
    return status;
  };
  for (const FrameIdx keyframe : odometry.keyframes) {
    text += fmt::format("VERTEX_SE3:QUAT {}", keyframe.value);
    AppendPose(odometry.at(keyframe).world_from_camera, text);
    text += '\n';
    if (Status status = pass_on(kPieceBytes); !status.ok()) return status;
  }
  if (!odometry.keyframes.empty())
    text += fmt::format("FIX {}\n", odometry.keyframes.front().value);
  Status written = Ok();
  odometry.ForEachEdge([&](const RelativePose& edge) {
    if (written.ok()) written = AppendEdge(edge, name, text);
    if (written.ok()) written = pass_on(kPieceBytes);
  });
  return written.ok() ? pass_on(0) : written;
}

Status DecodeG2oEdges(TextSource text, std::string_view name, const EdgeSink& take) {
  const auto decode = [&](std::string_view line) -> Status {
    const std::vector<std::string_view> words = Words(line);
    if (words.empty() || words[0].front() == '#' || words[0].starts_with("VERTEX_") ||
        words[0] == "FIX")
      return Ok();
    if (words[0] != "EDGE_SE3:QUAT")
      return InvalidInput(fmt::format("\"{}\" is no tag this program reads", words[0]));
    const Result<RelativePose> edge = DecodeEdge(words);
    if (!edge.ok()) return edge.error();
    return take(*edge);
  };
  return ForLines(std::move(text), name, decode);
}

}  // namespace deepslam::artifact
