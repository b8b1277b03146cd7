// Pose graphs in g2o's text format, both ways.
//
//   VERTEX_SE3:QUAT id x y z qx qy qz qw                    world_from_vertex
//   EDGE_SE3:QUAT i j x y z qx qy qz qw  I11 I12 ... I66    i_from_j, upper triangle by rows
//   FIX id
//
// g2o's error of an edge is (translation; quaternion's vector part, w >= 0) of z_ij^-1 x_i^-1 x_j.
// The vector part is half the rotation vector for small angles, r = D e with
// D = diag(1, 1, 1, 2, 2, 2), so a file's information is D Omega D: the rotation block times 4, the
// cross blocks times 2. Memory holds Omega, of (translation; rotation vector).
//
// g2o has no ground plane of this kind; its terms are comments that other programs skip and
// ParseG2o reads (information on two tangent directions and d, see scene/ground.h):
//   #DEEPSLAM_PLANE nx ny nz d
//   #DEEPSLAM_EDGE_PLANE i nx ny nz d  I11 I12 I13 I22 I23 I33
//   #DEEPSLAM_UPRIGHT id information
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::graph {

inline constexpr int kObjectVertexOffset = 100'000'000;  // vertex id of object 0; frames stay below

struct G2oEdge {
  int i = 0;
  int j = 0;
  Pose3 i_from_j;
  Matrix6d information = Matrix6d::Identity();  // of t2v, see above
};

struct G2oPlaneEdge {
  int i = 0;
  Plane plane_camera;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
};

struct G2oGraph {
  std::map<int, Pose3> vertices;
  std::vector<G2oEdge> edges;
  std::vector<int> fixed;
  std::optional<Plane> plane;
  std::vector<G2oPlaneEdge> plane_edges;
  std::map<int, double> upright;
};

// Numbers are the shortest text that reads back as the same double.
[[nodiscard]] std::string WriteG2o(const G2oGraph& graph);

// Unknown tags and other comments are skipped, as other programs do. Errors (kInvalidInput) name
// the line: too few or bad numbers, a quaternion of no length, a vertex given twice, an edge to a
// missing vertex.
[[nodiscard]] Result<G2oGraph> ParseG2o(std::string_view text);

// Sum of e^T I e over the pose edges by g2o's own convention, with the information as a file has
// it.
[[nodiscard]] double Chi2(const G2oGraph& graph);

}  // namespace deepslam::graph
