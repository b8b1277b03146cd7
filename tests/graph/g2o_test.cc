#include "deepslam/graph/g2o.h"

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam::graph {
namespace {

G2oGraph RandomGraph(double noise) {
  Random random(3);
  G2oGraph graph;
  const auto pose = [&random](double spread) {
    Vector6d v;
    for (int k = 0; k < 6; ++k) v[k] = random.Uniform(-spread, spread);
    return V2t(v);
  };
  for (int k = 0; k < 8; ++k) graph.vertices[10 * k] = pose(1.5);
  for (int k = 1; k < 8; ++k) {
    Matrix6d root;
    for (int n = 0; n < 36; ++n) root(n) = random.Normal();
    graph.edges.push_back(
        {10 * (k - 1),
         10 * k,
         graph.vertices[10 * (k - 1)].Inverse() * graph.vertices[10 * k] * pose(noise),
         root * root.transpose()});
  }
  graph.fixed = {0};
  graph.plane = Plane{Eigen::Vector3d(0.1, 0.2, 1).normalized(), 0.7};
  graph.plane_edges.push_back({10,
                               Plane{Eigen::Vector3d(0, -1, 0.1).normalized(), 1.2},
                               Eigen::Vector3d(3, 2, 1).asDiagonal()});
  graph.upright[20] = 13000;
  return graph;
}

TEST(G2o, RoundTripKeepsEveryBit) {
  const std::string text = WriteG2o(RandomGraph(0.1));
  const Result<G2oGraph> read = ParseG2o(text);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(WriteG2o(*read), text);
  EXPECT_EQ(read->vertices.size(), 8u);
  EXPECT_EQ(read->edges.size(), 7u);
  ASSERT_TRUE(read->plane.has_value());
  EXPECT_EQ(read->plane_edges.size(), 1u);
  EXPECT_EQ(read->upright.at(20), 13000);
}

// chi^2 of a file as g2o computes it, from the text alone: error (t; qx qy qz) of z^-1 x_i^-1 x_j
// by 4x4 matrices.
double ChiSquaredOfText(const std::string& text) {
  std::istringstream lines(text);
  std::map<int, Eigen::Matrix4d> vertices;
  double chi2 = 0;
  const auto matrix = [](std::istream& in) {
    double x, y, z, qx, qy, qz, qw;
    in >> x >> y >> z >> qx >> qy >> qz >> qw;
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = Eigen::Quaterniond(qw, qx, qy, qz).toRotationMatrix();
    m.topRightCorner<3, 1>() << x, y, z;
    return m;
  };
  for (std::string line; std::getline(lines, line);) {
    std::istringstream in(line);
    std::string tag;
    in >> tag;
    if (tag == "VERTEX_SE3:QUAT") {
      int id;
      in >> id;
      vertices[id] = matrix(in);
    } else if (tag == "EDGE_SE3:QUAT") {
      int i, j;
      in >> i >> j;
      const Eigen::Matrix4d z = matrix(in);
      const Eigen::Matrix4d d = z.inverse() * vertices[i].inverse() * vertices[j];
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(d.topLeftCorner<3, 3>()));
      Vector6d e;
      e << d.topRightCorner<3, 1>(), std::sin(0.5 * turn.angle()) * turn.axis();
      Matrix6d information;
      for (int r = 0; r < 6; ++r) {
        for (int c = r; c < 6; ++c) {
          in >> information(r, c);
          information(c, r) = information(r, c);
        }
      }
      chi2 += e.dot(information * e);
    }
  }
  return chi2;
}

TEST(G2o, Chi2IsTheOneOfTheTextByG2osConvention) {
  const G2oGraph graph = RandomGraph(0.3);
  EXPECT_NEAR(Chi2(graph) / ChiSquaredOfText(WriteG2o(graph)), 1.0, 1e-9);
}

TEST(G2o, Chi2AgreesWithRotationVectorsForSmallErrors) {
  const G2oGraph graph = RandomGraph(1e-3);
  double ours = 0;
  for (const G2oEdge& edge : graph.edges) {
    const Vector6d r = T2v(edge.i_from_j.Inverse() * graph.vertices.at(edge.i).Inverse() *
                           graph.vertices.at(edge.j));
    ours += r.dot(edge.information * r);
  }
  EXPECT_GT(ours, 0);
  EXPECT_NEAR(ChiSquaredOfText(WriteG2o(graph)) / ours, 1.0, 1e-4);
}

TEST(G2o, ForeignFilesAreRead) {
  const Result<G2oGraph> read = ParseG2o(
      "# made elsewhere\r\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\r\n\nVERTEX_SE3:QUAT 7 1e0 0 0 0 0 0 2\n"
      "VERTEX_TRACKXYZ 3 1 2 3\nFIX 0\n#DEEPSLAM_STAND 7 -0.45 20\n#DEEPSLAM_OTHER x\n"
      "EDGE_SE3:QUAT 0 7 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 4 0 0 4 0 4");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->fixed, std::vector<int>{0});
  EXPECT_NEAR(read->vertices.at(7).rotation.w(), 1.0, 1e-15);
  EXPECT_LT((read->edges.at(0).information - Matrix6d::Identity()).norm(), 1e-15);
}

TEST(G2o, FaultsNameTheLine) {
  const std::string vertex = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
  const std::pair<std::string, std::string> faults[] = {
      {vertex + "VERTEX_SE3:QUAT 1 0 0 0 0 0 1", "line 2: 8 numbers expected, 7 found"},
      {vertex + "\nVERTEX_SE3:QUAT 1 0 x 0 0 0 0 1", "line 3: x is not a number"},
      {vertex + vertex, "line 2: vertex 0 was given before"},
      {"VERTEX_SE3:QUAT 1 0 nan 0 0 0 0 1", "line 1: a number is not finite"},
      {"VERTEX_SE3:QUAT 1 0 0 0 0 0 0 0", "line 1: the quaternion has no length"},
      {vertex + "EDGE_SE3:QUAT 0 5 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 4 0 0 4 0 4",
       "line 2: edge to vertex 5"},
  };
  for (const auto& [text, message] : faults) {
    const Result<G2oGraph> read = ParseG2o(text);
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidInput);
    EXPECT_NE(read.error().message.find(message), std::string::npos) << read.error().message;
  }
}

TEST(G2o, AnEmptyTextIsAnEmptyGraph) {
  const Result<G2oGraph> read = ParseG2o("");
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(read->vertices.empty());
  EXPECT_EQ(WriteG2o(*read), "");
}

}  // namespace
}  // namespace deepslam::graph
