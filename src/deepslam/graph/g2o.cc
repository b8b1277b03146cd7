#include "deepslam/graph/g2o.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <system_error>

#include "deepslam/core/text_numbers.h"

namespace deepslam::graph {
namespace {

// Error per component: g2o's quaternion part is half our rotation vector, r = D e.
const Vector6d& RotationVectorPerG2oError() {
  static const Vector6d scale = (Vector6d() << 1, 1, 1, 2, 2, 2).finished();
  return scale;
}

Matrix6d ToG2o(const Matrix6d& information) {
  const Vector6d& d = RotationVectorPerG2oError();
  return d.asDiagonal() * information * d.asDiagonal();
}

Matrix6d FromG2o(const Matrix6d& information) {
  const Vector6d d = RotationVectorPerG2oError().cwiseInverse();
  return d.asDiagonal() * information * d.asDiagonal();
}

void Append(std::string& text, double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value == 0 ? 0.0 : value).ptr;
  text += ' ';
  text.append(buffer, end);
}

void Append(std::string& text, int value) {
  text += ' ';
  text += std::to_string(value);
}

void Append(std::string& text, const Pose3& pose) {
  for (int k = 0; k < 3; ++k) Append(text, pose.translation_m[k]);
  for (int k = 0; k < 4; ++k) Append(text, pose.rotation.coeffs()[k]);
}

void Append(std::string& text, const Plane& plane) {
  for (int k = 0; k < 3; ++k) Append(text, plane.normal[k]);
  Append(text, plane.d_m);
}

template <int N>
void AppendUpper(std::string& text, const Eigen::Matrix<double, N, N>& matrix) {
  for (int row = 0; row < N; ++row) {
    for (int col = row; col < N; ++col) Append(text, matrix(row, col));
  }
}

void WriteTermsOfTheGround(const G2oGraph& graph, std::string& text) {
  if (graph.plane) {
    text += "#DEEPSLAM_PLANE";
    Append(text, *graph.plane);
    text += '\n';
  }
  for (const G2oPlaneEdge& edge : graph.plane_edges) {
    text += "#DEEPSLAM_EDGE_PLANE";
    Append(text, edge.i);
    Append(text, edge.plane_camera);
    AppendUpper<3>(text, edge.information);
    text += '\n';
  }
  for (const auto& [id, information] : graph.upright) {
    text += "#DEEPSLAM_UPRIGHT";
    Append(text, id);
    Append(text, information);
    text += '\n';
  }
}

// Numbers of one line, with the first fault remembered.
class LineReader {
 public:
  LineReader(std::span<const std::string_view> words, std::size_t expected) : words_(words) {
    if (words.size() != expected) {
      fault_ = std::to_string(expected) + " numbers expected, " + std::to_string(words.size()) +
               " found";
    }
  }

  int Int() { return Number<int>(); }
  double Double() {
    const double value = Number<double>();
    if (!std::isfinite(value)) Fail("a number is not finite");
    return value;
  }
  Pose3 Pose() {
    Pose3 pose;
    for (int k = 0; k < 3; ++k) pose.translation_m[k] = Double();
    for (int k = 0; k < 4; ++k) pose.rotation.coeffs()[k] = Double();
    const double length = pose.rotation.norm();
    if (!(length > 1e-3 && std::isfinite(length))) {
      Fail("the quaternion has no length");
      return {};
    }
    // Unit quaternions are kept to the last bit, so that a file survives reading and writing.
    if (std::abs(length - 1.0) > 1e-12) pose.rotation.normalize();
    return pose;
  }
  deepslam::Plane Plane() {
    deepslam::Plane plane;
    for (int k = 0; k < 3; ++k) plane.normal[k] = Double();
    plane.d_m = Double();
    if (std::abs(plane.normal.norm() - 1.0) > 1e-3) Fail("the plane's normal has not length 1");
    return plane;
  }
  template <int N>
  Eigen::Matrix<double, N, N> Upper() {
    Eigen::Matrix<double, N, N> matrix;
    for (int row = 0; row < N; ++row) {
      for (int col = row; col < N; ++col) matrix(row, col) = matrix(col, row) = Double();
    }
    return matrix;
  }

  void Fail(const std::string& fault) {
    if (fault_.empty()) fault_ = fault;
  }
  [[nodiscard]] const std::string& fault() const { return fault_; }

 private:
  template <typename T>
  T Number() {
    T value{};
    if (!fault_.empty()) return value;
    const std::string_view word = words_[next_++];
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      Fail(std::string(word.substr(0, 40)).append(" is not a number"));
      return T{};
    }
    return value;
  }

  std::span<const std::string_view> words_;
  std::size_t next_ = 0;
  std::string fault_;
};

std::string ReadVertex(std::span<const std::string_view> words, G2oGraph& graph) {
  LineReader reader(words, 8);
  const int id = reader.Int();
  const Pose3 pose = reader.Pose();
  if (reader.fault().empty() && !graph.vertices.emplace(id, pose).second) {
    reader.Fail("vertex " + std::to_string(id) + " was given before");
  }
  return reader.fault();
}

std::string ReadEdge(std::span<const std::string_view> words, G2oGraph& graph) {
  LineReader reader(words, 30);
  G2oEdge edge;
  edge.i = reader.Int();
  edge.j = reader.Int();
  edge.i_from_j = reader.Pose();
  edge.information = FromG2o(reader.Upper<6>());
  graph.edges.push_back(edge);
  return reader.fault();
}

std::string ReadGroundTerm(std::span<const std::string_view> words, G2oGraph& graph) {
  const std::string_view tag = words.front();
  const std::span<const std::string_view> rest = words.subspan(1);
  if (tag == "#DEEPSLAM_PLANE") {
    LineReader reader(rest, 4);
    graph.plane = reader.Plane();
    return reader.fault();
  }
  if (tag == "#DEEPSLAM_EDGE_PLANE") {
    LineReader reader(rest, 11);
    G2oPlaneEdge edge;
    edge.i = reader.Int();
    edge.plane_camera = reader.Plane();
    edge.information = reader.Upper<3>();
    graph.plane_edges.push_back(edge);
    return reader.fault();
  }
  if (tag == "#DEEPSLAM_UPRIGHT") {
    LineReader reader(rest, 2);
    const int id = reader.Int();
    graph.upright[id] = reader.Double();
    return reader.fault();
  }
  return {};
}

std::string ReadLine(std::span<const std::string_view> words, G2oGraph& graph) {
  if (words.empty()) return {};
  if (words.front() == "VERTEX_SE3:QUAT") return ReadVertex(words.subspan(1), graph);
  if (words.front() == "EDGE_SE3:QUAT") return ReadEdge(words.subspan(1), graph);
  if (words.front() == "FIX") {
    for (const std::string_view& word : words.subspan(1)) {
      LineReader reader(std::span(&word, 1), 1);
      graph.fixed.push_back(reader.Int());
      if (!reader.fault().empty()) return reader.fault();
    }
    return {};
  }
  return ReadGroundTerm(words, graph);
}

}  // namespace

std::string WriteG2o(const G2oGraph& graph) {
  std::string text;
  text.reserve(graph.vertices.size() * 160 + graph.edges.size() * 600);
  for (const auto& [id, pose] : graph.vertices) {
    text += "VERTEX_SE3:QUAT";
    Append(text, id);
    Append(text, pose);
    text += '\n';
  }
  for (const int id : graph.fixed) {
    text += "FIX";
    Append(text, id);
    text += '\n';
  }
  for (const G2oEdge& edge : graph.edges) {
    text += "EDGE_SE3:QUAT";
    Append(text, edge.i);
    Append(text, edge.j);
    Append(text, edge.i_from_j);
    AppendUpper<6>(text, ToG2o(edge.information));
    text += '\n';
  }
  WriteTermsOfTheGround(graph, text);
  return text;
}

Result<G2oGraph> ParseG2o(std::string_view text) {
  G2oGraph graph;
  std::vector<int> edge_lines;
  int line_number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    ++line_number;
    const std::vector<std::string_view> words = Words(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string fault = ReadLine(words, graph);
    if (!fault.empty()) {
      return InvalidInput("g2o line " + std::to_string(line_number) + ": " + fault);
    }
    edge_lines.resize(graph.edges.size(), line_number);
  }
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    for (const int id : {graph.edges[k].i, graph.edges[k].j}) {
      if (graph.vertices.contains(id)) continue;
      return InvalidInput("g2o line " + std::to_string(edge_lines[k]) + ": edge to vertex " +
                          std::to_string(id) + ", which the file does not have");
    }
  }
  return graph;
}

double Chi2(const G2oGraph& graph) {
  double chi2 = 0;
  for (const G2oEdge& edge : graph.edges) {
    const Pose3 delta =
        edge.i_from_j.Inverse() * (graph.vertices.at(edge.i).Inverse() * graph.vertices.at(edge.j));
    Vector6d error;
    const double sign = delta.rotation.w() < 0 ? -1.0 : 1.0;
    error << delta.translation_m, sign * delta.rotation.vec();
    chi2 += error.dot(ToG2o(edge.information) * error);
  }
  return chi2;
}

}  // namespace deepslam::graph
