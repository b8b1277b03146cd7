#include "deepslam/mapping/keyframe_graph.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "graph/synthetic_graph.h"
#include "support/pose_matchers.h"

namespace deepslam::mapping {
namespace {

using ::deepslam::testing_support::PoseNear;
using graph::testing_support::AddMeasured;
using graph::testing_support::MakeWorld;
using graph::testing_support::Noise;
using graph::testing_support::World;

constexpr int kPerRound = 30;
constexpr Noise kNoise{0.01, 0.004, 0.02, 0.02};

// Two rounds, drifted, with loops from the second to the first.
World TwoRounds(int num_objects = 0) {
  World world = MakeWorld(2 * kPerRound, num_objects, 2, kNoise);
  AddMeasured({kPerRound, {}}, kNoise, 2, world);
  return world;
}

// Of the cameras about the first one, rms.
double Error_m(const std::vector<TrackedFrame>& frames, const World& world) {
  double sum = 0;
  const Pose3 first_from_tracking = frames.front().world_from_camera.Inverse();
  const Pose3 first_from_truth = world.world_from_camera.front().Inverse();
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Pose3 is = first_from_tracking * frames[k].world_from_camera;
    const Pose3 was = first_from_truth * world.world_from_camera[k];
    sum += (is.translation_m - was.translation_m).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(frames.size()));
}

TEST(SolvePath, LoopsTakeTheDriftOutOfAPath) {
  const World world = TwoRounds();
  const Result<SolvedPath> path = SolvePath(world.odometry, {}, world.loops.edges, {});
  ASSERT_TRUE(path.ok());
  const double drift_m = Error_m(world.odometry.frames, world);
  ASSERT_GT(drift_m, 0.05);
  EXPECT_LT(Error_m(path->frames, world), drift_m / 2);
}

TEST(SolvePath, WithoutLoopsAPathStaysAsItWas) {
  const World world = TwoRounds();
  const Result<SolvedPath> path = SolvePath(world.odometry, {}, {}, {});
  ASSERT_TRUE(path.ok());
  for (std::size_t k = 0; k < path->frames.size(); ++k) {
    EXPECT_THAT(path->frames[k].world_from_camera,
                PoseNear(world.odometry.frames[k].world_from_camera, 1e-6, 1e-4));
  }
}

// The optimizer turns its world to the ground; the path does not follow.
TEST(SolvePath, TheFirstKeyframeGroundAndObjectsStayInTheTrackingWorld) {
  World world = TwoRounds(4);
  const Result<SolvedPath> path =
      SolvePath(world.odometry, world.ground, world.loops.edges, {}, world.map);
  ASSERT_TRUE(path.ok());
  const Pose3 tracking_from_truth =
      world.odometry.frames.front().world_from_camera * world.world_from_camera.front().Inverse();
  EXPECT_THAT(path->frames.front().world_from_camera,
              PoseNear(world.odometry.frames.front().world_from_camera, 1e-9, 1e-6));
  ASSERT_TRUE(path->ground.plane_world.has_value());
  const Plane floor = Transformed(tracking_from_truth, Plane{});
  EXPECT_NEAR(path->ground.plane_world->d_m, floor.d_m, 0.02);
  EXPECT_GT(path->ground.plane_world->normal.dot(floor.normal), std::cos(0.01));
  ASSERT_EQ(path->world_from_object.size(), world.map.objects.size());
  for (std::size_t k = 0; k < path->world_from_object.size(); ++k) {
    EXPECT_THAT(path->world_from_object[k],
                PoseNear(tracking_from_truth * world.world_from_object[k], 0.1, 3.0));
  }
}

// A ground that was seen in a connected component of its own moves with that component.
TEST(SolvePath, GroundOfItsOwnMovesWithItsCameras) {
  World world = TwoRounds();
  const FrameIdx first{kPerRound + kPerRound / 2};
  const Pose3& tracked = world.odometry.at(first).world_from_camera;
  const Plane ground_camera = Transformed(tracked.Inverse(), Plane{});
  world.ground.apart.push_back({first, FrameIdx{2 * kPerRound}, Plane{}});
  const Result<SolvedPath> path =
      SolvePath(world.odometry, world.ground, world.loops.edges, {}, world.map);
  ASSERT_TRUE(path.ok());
  const Pose3& solved = path->frames[static_cast<std::size_t>(first.value)].world_from_camera;
  ASSERT_GT((solved.translation_m - tracked.translation_m).norm(), 0.01);
  ASSERT_TRUE(path->ground.apart.front().plane_world.has_value());
  const Plane again = Transformed(solved.Inverse(), *path->ground.apart.front().plane_world);
  EXPECT_NEAR(again.d_m, ground_camera.d_m, 1e-9);
  EXPECT_NEAR(again.normal.dot(ground_camera.normal), 1, 1e-9);
}

TEST(SolvePath, RefusesAPathOfWhichFramesAreMissing) {
  World world = TwoRounds();
  world.odometry.frames.erase(world.odometry.frames.begin() + 3);
  const Result<SolvedPath> path = SolvePath(world.odometry, {}, {}, {});
  ASSERT_FALSE(path.ok());
  EXPECT_EQ(path.error().code, ErrorCode::kInvalidInput);
}

}  // namespace
}  // namespace deepslam::mapping
