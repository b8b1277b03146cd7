// A path solved by overlapping sub-trajectories against the graph of the whole.
#include "deepslam/mapping/sub_trajectories.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/scene/edge_store.h"
#include "support/pose_matchers.h"

namespace deepslam::mapping {
namespace {

using ::deepslam::testing_support::PoseNear;

constexpr double kNoiseM = 0.004;
constexpr double kNoiseRad = 0.002;

Pose3 Disturbed(const Pose3& pose, Random& random, double times) {
  Vector6d error;
  for (int k = 0; k < 6; ++k) error[k] = times * (k < 3 ? kNoiseM : kNoiseRad) * random.Normal();
  return pose * V2t(error);
}

// Every second frame is a keyframe, registered to the five keyframes before it. The camera goes
// on by 5 cm and turns by 2 degrees a keyframe.
Odometry LongPath(int num_keyframes) {
  Random random(7, "long path", 0);
  Vector6d half_step;
  half_step << 0.025, 0, 0, 0, 0, 0.0175;
  std::vector<Pose3> truth(1);
  while (static_cast<int>(truth.size()) < 2 * num_keyframes)
    truth.push_back(truth.back() * V2t(half_step));
  Odometry odometry;
  Pose3 tracked;
  for (int k = 0; k < 2 * num_keyframes; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (k > 0) tracked = tracked * Disturbed(truth[at - 1].Inverse() * truth[at], random, 3);
    const FrameIdx keyframe{k - k % 2};
    odometry.frames.push_back(
        {FrameIdx{k}, 0.1 * k, tracked, TrackingStatus::kTracked, keyframe, 0, 1});
    if (k % 2 != 0) continue;
    odometry.keyframes.push_back(keyframe);
    for (int i = std::max(0, k - 10); i < k; i += 2) {
      RelativePose edge{FrameIdx{i}, FrameIdx{k}, {}, Matrix6d::Identity(), false};
      edge.i_from_j =
          Disturbed(truth[static_cast<std::size_t>(i)].Inverse() * truth[at], random, 1);
      Vector6d information;
      information << Eigen::Vector3d::Constant(1 / (kNoiseM * kNoiseM)),
          Eigen::Vector3d::Constant(1 / (kNoiseRad * kNoiseRad));
      edge.information = information.asDiagonal();
      odometry.edges.push_back(edge);
    }
  }
  return odometry;
}

std::vector<TrackedFrame> Solved(const Odometry& odometry, const SubTrajectorySizes& sizes) {
  graph::GraphOptions robust;
  robust.odometry_loss = "cauchy";
  robust.max_direct_keyframes = 1000;
  const Result<std::vector<TrackedFrame>> frames = SolveSubTrajectories(odometry, robust, sizes);
  EXPECT_TRUE(frames.ok());
  return frames.ok() ? *frames : std::vector<TrackedFrame>{};
}

Pose3 From(const std::vector<TrackedFrame>& frames, std::size_t i, std::size_t j) {
  return frames[i].world_from_camera.Inverse() * frames[j].world_from_camera;
}

class SubTrajectoriesOfAPath : public ::testing::TestWithParam<int> {};

// Also where the last sub-trajectory is hardly longer than what it shares with the one before.
TEST_P(SubTrajectoriesOfAPath, MakesThePathOfTheWhole) {
  const Odometry odometry = LongPath(GetParam());
  const std::vector<TrackedFrame> whole = Solved(odometry, {1000, 40});
  const std::vector<TrackedFrame> by_parts = Solved(odometry, {100, 40});
  ASSERT_EQ(by_parts.size(), odometry.frames.size());
  EXPECT_THAT(by_parts.front().world_from_camera,
              PoseNear(odometry.frames.front().world_from_camera, 1e-12, 1e-9));
  for (std::size_t k = 0; k < whole.size(); ++k) {
    if (k >= 20) {
      EXPECT_THAT(From(by_parts, k - 20, k), PoseNear(From(whole, k - 20, k), 1e-4, 0.005)) << k;
    }
    EXPECT_THAT(by_parts[k].world_from_camera, PoseNear(whole[k].world_from_camera, 2e-3, 0.05))
        << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Keyframes, SubTrajectoriesOfAPath, ::testing::Values(101, 160, 161, 300));

TEST(SolveSubTrajectories, OfAShortPathIsTheGraphOfTheWhole) {
  const Odometry odometry = LongPath(60);
  const std::vector<TrackedFrame> whole = Solved(odometry, {1000, 40});
  const std::vector<TrackedFrame> one = Solved(odometry, {60, 40});
  for (std::size_t k = 0; k < whole.size(); ++k)
    EXPECT_EQ(T2v(one[k].world_from_camera), T2v(whole[k].world_from_camera));
}

TEST(SolveSubTrajectories, TakesEdgesOutOfCoreAsThoseThatAreHeld) {
  const Odometry held = LongPath(300);
  Odometry out_of_core = held;
  const auto own = std::stable_partition(
      out_of_core.edges.begin(), out_of_core.edges.end(), [](const RelativePose& edge) {
        return edge.j.value - edge.i.value <= 2;  // from keyframe to keyframe
      });
  Odometry reordered = out_of_core;
  const auto store = std::make_shared<MemoryEdgeStore>();
  ASSERT_TRUE(AddAll({own, out_of_core.edges.end()}, *store).ok());
  out_of_core.more_edges = store;
  out_of_core.edges.erase(own, out_of_core.edges.end());
  ASSERT_GT(out_of_core.more_edges->size(), out_of_core.edges.size());
  for (const SubTrajectorySizes& sizes :
       {SubTrajectorySizes{100, 40}, SubTrajectorySizes{1000, 40}}) {
    const std::vector<TrackedFrame> expected = Solved(reordered, sizes);
    const std::vector<TrackedFrame> solved = Solved(out_of_core, sizes);
    ASSERT_EQ(solved.size(), expected.size());
    for (std::size_t k = 0; k < solved.size(); ++k)
      EXPECT_EQ(solved[k].world_from_camera, expected[k].world_from_camera) << k;
  }
}

// A measured path has less error than a tracked one, whichever way it is solved.
TEST(SolveSubTrajectories, MovesThePath) {
  const Odometry odometry = LongPath(160);
  const std::vector<TrackedFrame> by_parts = Solved(odometry, {100, 40});
  const Pose3 moved =
      odometry.frames.back().world_from_camera.Inverse() * by_parts.back().world_from_camera;
  EXPECT_GT(moved.translation_m.norm(), 0.01);
}

}  // namespace
}  // namespace deepslam::mapping
