#include "deepslam/graph/condense.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

namespace deepslam::graph {
namespace {

// Chi^2 of six degrees of freedom, and beyond what nearly all measurements reach that are right.
constexpr double kAgree = 25;

double Chi2(const Pose3& expected, const PoseEdge& edge) {
  const Vector6d off = T2v(edge.a_from_b.Inverse() * expected);
  return off.dot(edge.information * off);
}

// Per keyframe: tracking measured it from the one before.
std::vector<bool> Follows(const Odometry& odometry) {
  std::vector<bool> follows(odometry.keyframes.size(), false);
  odometry.ForEachEdge([&](const RelativePose& edge) {
    if (edge.composed || !(edge.information.Full().diagonal().maxCoeff() > 0)) return;
    const int newer = PositionOf(odometry.keyframes, edge.j);
    if (newer > 0 && odometry.keyframes[static_cast<std::size_t>(newer) - 1] == edge.i)
      follows[static_cast<std::size_t>(newer)] = true;
  });
  return follows;
}

// Keyframes that measurements from up to `reach` before them put elsewhere begin a new node.
void LeaveOutContradicted(const GraphModel& model,
                          const EachPoseEdge& measured,
                          int reach,
                          std::vector<bool>& follows) {
  measured([&](const PoseEdge& edge) {
    if (edge.kind == EdgeKind::kObject || std::abs(edge.b - edge.a) >= reach) return;
    const Pose3& world_from_a = model.world_from_node[static_cast<std::size_t>(edge.a)];
    const Pose3& world_from_b = model.world_from_node[static_cast<std::size_t>(edge.b)];
    if (Chi2(world_from_a.Inverse() * world_from_b, edge) > kAgree)
      follows[static_cast<std::size_t>(std::max(edge.a, edge.b))] = false;
  });
}

// Which keyframes one node stands for: ascending, and whether the next node follows.
struct Nodes {
  std::vector<int> of_keyframe;
  std::vector<bool> next_follows;
};

Nodes NodesOf(const std::vector<bool>& follows, int keyframes_per_node) {
  Nodes nodes;
  int in_node = 0;
  for (const bool goes_on : follows) {
    if (nodes.of_keyframe.empty() || !goes_on || in_node == keyframes_per_node) {
      if (!nodes.next_follows.empty()) nodes.next_follows.back() = goes_on;
      nodes.next_follows.push_back(false);
      in_node = 0;
    }
    ++in_node;
    nodes.of_keyframe.push_back(static_cast<int>(nodes.next_follows.size()) - 1);
  }
  return nodes;
}

// Without directions that next to nothing was measured in.
Vector6d Solve(const Matrix6d& information, const Vector6d& right_side) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(information);
  const double least = 1e-9 * solver.eigenvalues().maxCoeff();
  const Vector6d inverse =
      solver.eigenvalues().unaryExpr([&](double l) { return l > least ? 1 / l : 0.0; });
  const Matrix6d& basis = solver.eigenvectors();
  return basis * (inverse.asDiagonal() * (basis.transpose() * right_side));
}

// Measurements between two nodes that agree.
struct Bundle {
  PoseEdge first;
  Matrix6d information = Matrix6d::Zero();   // their sum
  Vector6d weighted_off = Vector6d::Zero();  // Omega t2v(first^-1 measured), their sum

  explicit Bundle(const PoseEdge& edge) : first(edge), information(edge.information) {}

  // Whether it agrees, and is one of them from now on. Both are off, so half of the square is
  // compared; where one is less sure, that is as far as it can tell.
  [[nodiscard]] bool Take(const PoseEdge& edge) {
    const double chi2 = std::min(Chi2(edge.a_from_b, first), Chi2(first.a_from_b, edge));
    if (0.5 * chi2 > kAgree) return false;
    information += edge.information;
    weighted_off += edge.information * T2v(first.a_from_b.Inverse() * edge.a_from_b);
    first.weight += edge.weight;
    return true;
  }

  [[nodiscard]] PoseEdge Mean() const {
    PoseEdge mean = first;
    mean.a_from_b = first.a_from_b * V2t(Solve(information, weighted_off));
    mean.information = information / first.weight;
    return mean;
  }
};

class Condenser {
 public:
  Condenser(GraphModel model, const Nodes& nodes)
      : model_(std::move(model)), num_keyframes_(model_.num_keyframes()) {
    condensed_.node_of_keyframe = nodes.of_keyframe;
    for (int k = 0; k < num_keyframes_; ++k) {
      const int node = NodeOf(k);
      if (node == condensed_.num_keyframes()) {
        condensed_.keyframes.push_back(model_.keyframes[static_cast<std::size_t>(k)]);
        condensed_.blend_from.push_back(model_.keyframes[static_cast<std::size_t>(k)]);
        condensed_.world_from_node.push_back(Before(k));
      }
      if (!nodes.next_follows[static_cast<std::size_t>(node)])
        condensed_.blend_from.back() = model_.keyframes[static_cast<std::size_t>(k)];
      node_from_before_.push_back(condensed_.world_from_node.back().Inverse() * Before(k));
    }
    for (std::size_t k = static_cast<std::size_t>(num_keyframes_);
         k < model_.world_from_node.size();
         ++k) {
      condensed_.world_from_node.push_back(model_.world_from_node[k]);
      node_from_before_.emplace_back();
    }
  }

  GraphModel Take(const EachPoseEdge& measured) && {
    CarryPoseEdges(measured);
    for (const GroundEdge& edge : model_.ground_edges)
      condensed_.ground_edges.push_back(Carried(edge));
    condensed_.walls = std::move(model_.walls);
    for (const WallEdge& edge : model_.wall_edges)
      condensed_.wall_edges.push_back({edge.wall, Carried(edge.view)});
    for (const int node : model_.upright) condensed_.upright.push_back(NodeOf(node));
    condensed_.objects = std::move(model_.objects);
    condensed_.plane = model_.plane;
    condensed_.not_standing = std::move(model_.not_standing);
    condensed_.num_bad_edges = model_.num_bad_edges;
    condensed_.num_ties = model_.num_ties;
    return std::move(condensed_);
  }

 private:
  [[nodiscard]] const Pose3& Before(int node) const {
    return model_.world_from_node[static_cast<std::size_t>(node)];
  }
  // Keyframes come first, then objects, in both graphs.
  [[nodiscard]] int NodeOf(int before) const {
    if (before < num_keyframes_)
      return condensed_.node_of_keyframe[static_cast<std::size_t>(before)];
    return condensed_.num_keyframes() + before - num_keyframes_;
  }
  [[nodiscard]] const Pose3& NodeFrom(int before) const {
    return node_from_before_[static_cast<std::size_t>(before)];
  }

  [[nodiscard]] PoseEdge Carried(const PoseEdge& edge) const {
    const Pose3 b_from_node = NodeFrom(edge.b).Inverse();
    const Matrix6d adjoint = Adjoint(b_from_node);
    PoseEdge carried = edge;
    carried.a = NodeOf(edge.a);
    carried.b = NodeOf(edge.b);
    carried.a_from_b = NodeFrom(edge.a) * edge.a_from_b * b_from_node;
    carried.information = adjoint.transpose() * edge.information * adjoint;
    return carried;
  }

  // Errors of the measured plane, turns about its tangents and of its distance, move with it:
  // n' = R n, d' = d - n'^T t.
  [[nodiscard]] GroundEdge Carried(const GroundEdge& edge) const {
    const Pose3& node_from_camera = NodeFrom(edge.node);
    GroundEdge carried = edge;
    carried.node = NodeOf(edge.node);
    carried.plane_camera = Transformed(node_from_camera, edge.plane_camera);
    const Eigen::Matrix<double, 3, 2> turned =
        node_from_camera.rotation.toRotationMatrix() * GroundTangentBasis(edge.plane_camera.normal);
    Eigen::Matrix3d after_from_before = Eigen::Matrix3d::Identity();
    after_from_before.topLeftCorner<2, 2>() =
        GroundTangentBasis(carried.plane_camera.normal).transpose() * turned;
    after_from_before.bottomLeftCorner<1, 2>() =
        -node_from_camera.translation_m.transpose() * turned;
    const Eigen::Matrix3d before_from_after = after_from_before.inverse();
    carried.information = before_from_after.transpose() * edge.information * before_from_after;
    return carried;
  }

  void CarryPoseEdges(const EachPoseEdge& measured) {
    std::map<std::tuple<EdgeKind, int, int>, std::vector<Bundle>> bundles;
    measured([&](const PoseEdge& edge) {
      const PoseEdge carried = Carried(edge);
      if (carried.a == carried.b) return;
      std::vector<Bundle>& of_pair = bundles[{carried.kind, carried.a, carried.b}];
      const bool taken =
          std::ranges::any_of(of_pair, [&](Bundle& bundle) { return bundle.Take(carried); });
      if (!taken) of_pair.emplace_back(carried);
    });
    for (const auto& [pair, of_pair] : bundles) {
      for (const Bundle& bundle : of_pair) condensed_.pose_edges.push_back(bundle.Mean());
    }
  }

  GraphModel model_;
  const int num_keyframes_;  // of the model
  GraphModel condensed_;
  std::vector<Pose3> node_from_before_;
};

}  // namespace

GraphModel Condensed(GraphModel model,
                     const EachPoseEdge& along_path,
                     const Odometry& odometry,
                     int max_nodes) {
  const std::vector<PoseEdge> own = std::move(model.pose_edges);
  model.pose_edges = {};
  const EachPoseEdge measured = [&](const std::function<void(const PoseEdge&)>& use) {
    along_path(use);
    std::ranges::for_each(own, use);
  };
  if (model.num_keyframes() <= max_nodes) {
    measured([&](const PoseEdge& edge) { model.pose_edges.push_back(edge); });
    return model;
  }
  const int keyframes_per_node = (model.num_keyframes() + max_nodes - 1) / max_nodes;
  std::vector<bool> follows = Follows(odometry);
  LeaveOutContradicted(model, measured, keyframes_per_node, follows);
  return Condenser(std::move(model), NodesOf(follows, keyframes_per_node)).Take(measured);
}

}  // namespace deepslam::graph
