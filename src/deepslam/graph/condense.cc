#include "deepslam/graph/condense.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <tuple>
#include <utility>

#include <Eigen/QR>

namespace deepslam::graph {
namespace {

constexpr double kAgree = 25;  // chi^2 of six degrees of freedom; 0.9997 of those that are right

// Per keyframe: tracking measured it from the one before.
std::vector<bool> Follows(const Odometry& odometry) {
  std::vector<bool> follows(odometry.keyframes.size(), false);
  for (const RelativePose& edge : odometry.edges) {
    if (edge.composed) continue;
    const auto newer = std::ranges::lower_bound(odometry.keyframes, edge.j);
    if (newer == odometry.keyframes.begin() || newer == odometry.keyframes.end()) continue;
    if (*newer == edge.j && *std::prev(newer) == edge.i)
      follows[static_cast<std::size_t>(newer - odometry.keyframes.begin())] = true;
  }
  return follows;
}

std::vector<int> NodesOfKeyframes(const Odometry& odometry, int keyframes_per_node) {
  const std::vector<bool> follows = Follows(odometry);
  std::vector<int> nodes;
  int num_nodes = 0;
  int in_node = keyframes_per_node;
  for (const bool goes_on : follows) {
    if (!goes_on || in_node == keyframes_per_node) {
      ++num_nodes;
      in_node = 0;
    }
    ++in_node;
    nodes.push_back(num_nodes - 1);
  }
  return nodes;
}

// Measurements between two nodes that agree.
struct Bundle {
  PoseEdge first;
  Matrix6d information = Matrix6d::Zero();   // their sum
  Vector6d weighted_off = Vector6d::Zero();  // Omega t2v(first^-1 measured), their sum

  explicit Bundle(const PoseEdge& edge) : first(edge), information(edge.information) {}

  // Whether it agrees, and is one of them from now on.
  [[nodiscard]] bool Take(const PoseEdge& edge) {
    const Vector6d off = T2v(first.a_from_b.Inverse() * edge.a_from_b);
    if (off.dot(edge.information * off) > kAgree) return false;
    information += edge.information;
    weighted_off += edge.information * off;
    first.weight += edge.weight;
    return true;
  }

  [[nodiscard]] PoseEdge Mean() const {
    PoseEdge mean = first;
    const Vector6d off =
        information.completeOrthogonalDecomposition().solve(weighted_off);  // some are singular
    mean.a_from_b = first.a_from_b * V2t(off);
    mean.information = information / first.weight;
    return mean;
  }
};

class Condenser {
 public:
  Condenser(GraphModel model, std::vector<int> node_of_keyframe)
      : model_(std::move(model)), num_keyframes_(model_.num_keyframes()) {
    condensed_.node_of_keyframe = std::move(node_of_keyframe);
    for (int k = 0; k < num_keyframes_; ++k) {
      const int node = NodeOf(k);
      if (node == condensed_.num_keyframes()) {
        condensed_.keyframes.push_back(model_.keyframes[static_cast<std::size_t>(k)]);
        condensed_.world_from_node.push_back(Before(k));
      }
      node_from_before_.push_back(condensed_.world_from_node.back().Inverse() * Before(k));
    }
    for (std::size_t k = static_cast<std::size_t>(num_keyframes_);
         k < model_.world_from_node.size();
         ++k) {
      condensed_.world_from_node.push_back(model_.world_from_node[k]);
      node_from_before_.emplace_back();
    }
  }

  GraphModel Take() && {
    CarryPoseEdges();
    for (const GroundEdge& edge : model_.ground_edges)
      condensed_.ground_edges.push_back(Carried(edge));
    for (const int node : model_.upright) condensed_.upright.push_back(NodeOf(node));
    for (StandEdge edge : model_.stands) {
      edge.node = NodeOf(edge.node);
      condensed_.stands.push_back(edge);
    }
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

  void CarryPoseEdges() {
    std::map<std::tuple<EdgeKind, int, int>, std::vector<Bundle>> bundles;
    for (const PoseEdge& edge : model_.pose_edges) {
      const PoseEdge carried = Carried(edge);
      if (carried.a == carried.b) continue;
      std::vector<Bundle>& of_pair = bundles[{carried.kind, carried.a, carried.b}];
      const bool taken =
          std::ranges::any_of(of_pair, [&](Bundle& bundle) { return bundle.Take(carried); });
      if (!taken) of_pair.emplace_back(carried);
    }
    model_.pose_edges = std::vector<PoseEdge>();
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

GraphModel Condensed(GraphModel model, const Odometry& odometry, int max_nodes) {
  if (model.num_keyframes() <= max_nodes) return model;
  const int keyframes_per_node = (model.num_keyframes() + max_nodes - 1) / max_nodes;
  return Condenser(std::move(model), NodesOfKeyframes(odometry, keyframes_per_node)).Take();
}

}  // namespace deepslam::graph
