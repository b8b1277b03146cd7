#include "deepslam/graph/condense.h"

#include <algorithm>
#include <functional>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"
#include "deepslam/graph/information.h"
#include "deepslam/graph/residuals.h"
#include "graph/expect_truth.h"
#include "graph/synthetic_graph.h"
#include "support/pose_matchers.h"

namespace deepslam::graph {
namespace {

using ::deepslam::testing_support::PoseNear;
using ::testing::ElementsAre;
using testing_support::AddMeasured;
using testing_support::Disturbance;
using testing_support::ExpectTruth;
using testing_support::MakeWorld;
using testing_support::Noise;
using testing_support::RefineLocally;
using testing_support::TrajectoryError;
using testing_support::World;

const Noise kDrift{0.004, 0.003, 0.02, 0.02};

GraphModel WholeModel(const World& world) {
  return *BuildGraphModel(
      world.odometry, world.ground, world.map, world.loops, {}, {world.feet, {}});
}

OptimizedMap Optimize(const World& world, int max_keyframes) {
  GraphOptions options;
  options.max_keyframes = max_keyframes;
  Result<OptimizedMap> result = OptimizeGraph(
      world.odometry, world.ground, world.map, world.loops, options, {world.feet, {}});
  EXPECT_TRUE(result.ok());
  return *std::move(result);
}

// A pose block of residuals.h.
std::vector<double> Block(const Pose3& pose) {
  const Eigen::Vector4d q = pose.rotation.coeffs();
  const Eigen::Vector3d& t = pose.translation_m;
  return {q[0], q[1], q[2], q[3], t[0], t[1], t[2]};
}

double Cost(const PoseEdge& edge, const std::vector<Pose3>& world_from_node) {
  const PoseResidual residual{edge.a_from_b.Inverse(), SqrtInformation<6>(edge.information)};
  Vector6d r;
  residual(Block(world_from_node[static_cast<std::size_t>(edge.a)]).data(),
           Block(world_from_node[static_cast<std::size_t>(edge.b)]).data(),
           r.data());
  return edge.weight * r.squaredNorm();
}

double Cost(const GroundEdge& edge, const Plane& plane, const std::vector<Pose3>& world_from_node) {
  const GroundResidual residual{GroundTangentBasis(edge.plane_camera.normal),
                                edge.plane_camera.d_m,
                                SqrtInformation<3>(edge.information)};
  const std::vector<double> p = {plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.d_m};
  Eigen::Vector3d r;
  residual(Block(world_from_node[static_cast<std::size_t>(edge.node)]).data(), p.data(), r.data());
  return r.squaredNorm();
}

template <int N>
Eigen::Matrix<double, N, N> AnyInformation(Random& random) {
  Eigen::Matrix<double, N, N> root;
  for (int k = 0; k < N * N; ++k) root.data()[k] = random.Normal();
  return 1e4 * (root.transpose() * root + Eigen::Matrix<double, N, N>::Identity());
}

// All measurements are the model's own.
GraphModel Condense(const GraphModel& model, const Odometry& odometry, int max_nodes) {
  const auto none = [](const std::function<void(const PoseEdge&)>& /*use*/) {};
  return Condensed(model, none, odometry, max_nodes);
}

TEST(Condensed, IsTheModelItselfWhereItIsSmallEnough) {
  const World world = MakeWorld(40, 4, 1, kDrift);
  const GraphModel whole = WholeModel(world);
  const GraphModel same = Condense(whole, world.odometry, 40);
  EXPECT_EQ(same.keyframes, whole.keyframes);
  EXPECT_EQ(same.pose_edges.size(), whole.pose_edges.size());
  EXPECT_EQ(same.num_keyframes(), 40);
}

TEST(Condensed, MeasurementsHandedOverOneByOneAreAsTheModelsOwn) {
  const World world = MakeWorld(41, 4, 1, kDrift);
  const GraphModel whole = WholeModel(world);
  GraphModel rest = whole;
  rest.pose_edges.erase(rest.pose_edges.begin(), rest.pose_edges.begin() + 30);
  const auto first = [&](const std::function<void(const PoseEdge&)>& use) {
    std::for_each(whole.pose_edges.begin(), whole.pose_edges.begin() + 30, use);
  };
  for (const int max_nodes : {100, 11}) {
    const GraphModel at_once = Condense(whole, world.odometry, max_nodes);
    const GraphModel one_by_one = Condensed(rest, first, world.odometry, max_nodes);
    ASSERT_EQ(one_by_one.pose_edges.size(), at_once.pose_edges.size());
    for (std::size_t k = 0; k < at_once.pose_edges.size(); ++k) {
      EXPECT_EQ(one_by_one.pose_edges[k].a, at_once.pose_edges[k].a);
      EXPECT_EQ(one_by_one.pose_edges[k].b, at_once.pose_edges[k].b);
      EXPECT_EQ(one_by_one.pose_edges[k].a_from_b, at_once.pose_edges[k].a_from_b);
      EXPECT_EQ(one_by_one.pose_edges[k].information, at_once.pose_edges[k].information);
      EXPECT_EQ(one_by_one.pose_edges[k].weight, at_once.pose_edges[k].weight);
    }
  }
}

TEST(Condensed, NodesAreRunsOfKeyframesAndObjectsStay) {
  const World world = MakeWorld(41, 4, 1, kDrift);
  const GraphModel condensed = Condense(WholeModel(world), world.odometry, 11);
  EXPECT_EQ(condensed.num_keyframes(), 11);
  EXPECT_EQ(condensed.node_of_keyframe.size(), 41u);
  EXPECT_TRUE(std::ranges::is_sorted(condensed.node_of_keyframe));
  for (std::size_t node = 0; node < condensed.keyframes.size(); ++node)
    EXPECT_EQ(condensed.keyframes[node].value, 4 * static_cast<int>(node));
  EXPECT_EQ(condensed.objects.size(), 4u);
  EXPECT_EQ(condensed.world_from_node.size(), 15u);
  for (const PoseEdge& edge : condensed.pose_edges) {
    EXPECT_NE(edge.a, edge.b);
    EXPECT_LT(edge.a, 11);
    EXPECT_EQ(edge.kind == EdgeKind::kObject, edge.b >= 11);
  }
  for (const int node : condensed.upright) EXPECT_GE(node, 11);
  EXPECT_EQ(condensed.upright.size(), 4u);
}

TEST(Condensed, ANodeEndsWhereTrackingWasLost) {
  World world = MakeWorld(12, 1, 0.2, kDrift);
  world.odometry.edges[5].composed = true;  // from keyframe 5 to 6
  const GraphModel condensed = Condense(WholeModel(world), world.odometry, 3);
  EXPECT_THAT(condensed.node_of_keyframe, ElementsAre(0, 0, 0, 0, 1, 1, 2, 2, 2, 2, 3, 3));
}

// A walk in two pieces, the second of which a loop puts elsewhere.
TEST(Condensed, WhatLiesBeforeALossIsNotDrawnBehindIt) {
  World world = MakeWorld(60, 0, 0.6, {});
  world.ground = {};
  world.odometry.edges[29].composed = true;  // from keyframe 29 to 30
  world.odometry.edges[29].information = 1e-10 * world.odometry.edges[29].information.Full();
  const Pose3 lost{Eigen::Quaterniond::Identity(), {2, 0.5, 0}};
  for (std::size_t k = 30; k < 60; ++k) {
    Pose3& tracked = world.odometry.frames[k].world_from_camera;
    tracked = lost * tracked;
  }
  world.odometry.edges[29].i_from_j = world.odometry.frames[29].world_from_camera.Inverse() *
                                      world.odometry.frames[30].world_from_camera;
  world.loops.edges.push_back({FrameIdx{3},
                               FrameIdx{55},
                               world.world_from_camera[3].Inverse() * world.world_from_camera[55],
                               testing_support::Information(0.01, 0.01),
                               false});
  const std::vector<TrackedFrame> frames = Optimize(world, 9).frames;
  for (std::size_t k = 1; k < 60; ++k) {
    if (k == 30) continue;
    EXPECT_THAT(
        frames[k - 1].world_from_camera.Inverse() * frames[k].world_from_camera,
        PoseNear(world.world_from_camera[k - 1].Inverse() * world.world_from_camera[k], 1e-3, 0.05))
        << k;
  }
  EXPECT_THAT(
      frames[3].world_from_camera.Inverse() * frames[55].world_from_camera,
      PoseNear(world.world_from_camera[3].Inverse() * world.world_from_camera[55], 0.01, 0.2));
}

// As where depth slid and images measured the same two keyframes again.
TEST(Condensed, ANodeEndsWhereAMeasurementWithinItContradictsThePath) {
  World world = MakeWorld(12, 0, 0.2, {});
  for (std::size_t k = 6; k < 12; ++k)
    world.odometry.frames[k].world_from_camera.translation_m.x() += 0.2;
  world.odometry.edges[5].i_from_j = world.odometry.frames[5].world_from_camera.Inverse() *
                                     world.odometry.frames[6].world_from_camera;
  const RelativePose again{FrameIdx{5},
                           FrameIdx{6},
                           world.world_from_camera[5].Inverse() * world.world_from_camera[6],
                           testing_support::Information(0.01, 0.01),
                           false};
  EXPECT_THAT(Condense(WholeModel(world), world.odometry, 3).node_of_keyframe,
              ElementsAre(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2));
  world.loops.edges.push_back(again);
  EXPECT_THAT(Condense(WholeModel(world), world.odometry, 3).node_of_keyframe,
              ElementsAre(0, 0, 0, 0, 1, 1, 2, 2, 2, 2, 3, 3));
  const std::vector<TrackedFrame> frames = Optimize(world, 3).frames;
  EXPECT_THAT(
      frames[4].world_from_camera.Inverse() * frames[7].world_from_camera,
      PoseNear(world.world_from_camera[4].Inverse() * world.world_from_camera[7], 0.01, 0.2));
}

// What all edges say of nodes that are off is what they said of their keyframes.
TEST(Condensed, CarriesMeasurementsWithTheirInformation) {
  Random random(3);
  World world = MakeWorld(6, 0, 0.3, {});
  world.ground.observations.clear();
  GraphModel whole = WholeModel(world);
  whole.pose_edges = {{EdgeKind::kLoop,
                       1,
                       5,
                       whole.world_from_node[1].Inverse() * whole.world_from_node[5],
                       AnyInformation<6>(random)}};
  const Plane plane{Eigen::Vector3d(0.2, -0.5, 0.7).normalized(), 1.3};
  whole.plane = plane;
  whole.ground_edges = {
      {5, Transformed(whole.world_from_node[5].Inverse(), plane), AnyInformation<3>(random)}};
  const GraphModel condensed = Condense(whole, world.odometry, 2);
  ASSERT_EQ(condensed.pose_edges.size(), 1u);
  ASSERT_EQ(condensed.ground_edges.size(), 1u);
  EXPECT_NEAR(Cost(condensed.pose_edges[0], condensed.world_from_node), 0, 1e-12);
  EXPECT_NEAR(Cost(condensed.ground_edges[0], plane, condensed.world_from_node), 0, 1e-12);
  for (int n = 0; n < 20; ++n) {
    std::vector<Pose3> nodes = condensed.world_from_node;
    nodes[1] = nodes[1] * Disturbance(random, 1e-4, 1e-4);
    std::vector<Pose3> keyframes = whole.world_from_node;
    for (std::size_t k = 3; k < 6; ++k) {
      keyframes[k] = nodes[1] * condensed.world_from_node[1].Inverse() * whole.world_from_node[k];
    }
    const double of_pose = Cost(whole.pose_edges[0], keyframes);
    EXPECT_NEAR(Cost(condensed.pose_edges[0], nodes), of_pose, 1e-3 * of_pose);
    const double of_ground = Cost(whole.ground_edges[0], plane, keyframes);
    EXPECT_NEAR(Cost(condensed.ground_edges[0], plane, nodes), of_ground, 2e-3 * of_ground);
  }
}

TEST(Condensed, WhatAgreesIsOneEdgeAndWhatDoesNotStaysApart) {
  Random random(5);
  World world = MakeWorld(8, 0, 0.3, {});
  GraphModel whole = WholeModel(world);
  whole.pose_edges.clear();
  const Matrix6d information = testing_support::Information(0.01, 0.01);
  Vector6d sum = Vector6d::Zero();
  const auto add = [&](int a, int b, const Pose3& off) {
    const Pose3 measured = (whole.world_from_node[static_cast<std::size_t>(a)].Inverse() *
                            whole.world_from_node[static_cast<std::size_t>(b)]) *
                           off;
    whole.pose_edges.push_back({EdgeKind::kLoop, a, b, measured, information});
  };
  for (int n = 0; n < 9; ++n) {  // to the node's own keyframe, so that all have the same weight
    const Pose3 off = Disturbance(random, 0.005, 0.005);
    sum += T2v(off);
    add(n % 4, 4, off);
  }
  add(2, 4, Pose3{Eigen::Quaterniond::Identity(), {0.3, 0, 0}});
  const GraphModel condensed = Condense(whole, world.odometry, 2);
  ASSERT_EQ(condensed.pose_edges.size(), 2u);
  const PoseEdge& mean = condensed.pose_edges[0];
  EXPECT_EQ(mean.weight, 9);
  EXPECT_TRUE(mean.information.isApprox(information, 1e-6));
  const Pose3 off =
      (condensed.world_from_node[0].Inverse() * condensed.world_from_node[1]).Inverse() *
      mean.a_from_b;
  EXPECT_LT((T2v(off) - sum / 9).norm(), 1e-4);
  EXPECT_EQ(condensed.pose_edges[1].weight, 1);
}

TEST(Condensed, TheTruthStaysTheTruth) {
  World world = MakeWorld(90, 5, 2, {});
  AddMeasured({45, {5, 10}, false}, {}, 1, world);
  const OptimizedMap map = Optimize(world, 30);
  double before = 0;
  for (const EnergyTerm& term : map.summary.terms) before += term.before;
  EXPECT_LT(before, 1e-12);
  ExpectTruth(map, world);
}

TEST(Condensed, APathThatGoesRoundComesHomeAsTheWholeGraphBringsIt) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    World world = MakeWorld(480, 6, 4, kDrift, seed);
    AddMeasured({120, {2, 3, 5, 7, 10, 15}, false}, kDrift, seed, world);
    RefineLocally(world);
    const double whole_m = TrajectoryError(Optimize(world, 480).frames, world);
    const OptimizedMap map = Optimize(world, 160);
    EXPECT_TRUE(map.summary.converged) << map.summary.message;
    EXPECT_THAT(map.summary.message, ::testing::HasSubstr("480 keyframes solved as 160"));
    const double condensed_m = TrajectoryError(map.frames, world);
    EXPECT_LT(condensed_m, whole_m + 0.004) << whole_m;  // one step of tracking
  }
}

}  // namespace
}  // namespace deepslam::graph
