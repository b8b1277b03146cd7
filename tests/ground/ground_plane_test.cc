#include "deepslam/ground/ground_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "deepslam/core/parallel.h"
#include "deepslam/dataset/memory_frame_source.h"
#include "odometry/box_world.h"

namespace deepslam::ground {
namespace {

using dataset::MemoryFrameSource;
using testing_support::BoxWorld;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::RenderFrame;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
// Depth noise of about 1 cm at these distances over some thousand pixels.
constexpr double kToleranceM = 0.01;
constexpr double kToleranceDeg = 0.5;

// Every frame a keyframe with its true pose, in the tracking world of the first.
struct TrueCapture {
  std::vector<Frame> frames;
  Odometry odometry;
  Pose3 world_from_first;  // world: z up, floor z = 0
};

TrueCapture Capture(const BoxWorld& world, const std::vector<Pose3>& poses, double noise = 1.0) {
  TrueCapture capture;
  capture.world_from_first = poses.front();
  for (std::size_t k = 0; k < poses.size(); ++k) {
    capture.frames.push_back(RenderFrame(world, poses[k], noise, k));
    TrackedFrame frame;
    frame.frame = FrameIdx{static_cast<std::int32_t>(k)};
    frame.keyframe = frame.frame;
    frame.world_from_camera = poses.front().Inverse() * poses[k];
    capture.odometry.frames.push_back(frame);
    capture.odometry.keyframes.push_back(frame.frame);
  }
  return capture;
}

Ground Estimate(const TrueCapture& capture, const GroundOptions& options = {}) {
  const MemoryFrameSource source(kSmallCamera, capture.frames);
  SilentProgress progress;
  Result<Ground> ground = EstimateGround(source, capture.odometry, options, progress);
  EXPECT_TRUE(ground.ok());
  return std::move(ground).value();
}

void ExpectFloor(const TrueCapture& capture,
                 const Ground& ground,
                 double tolerance_m = kToleranceM,
                 double tolerance_deg = kToleranceDeg) {
  ASSERT_TRUE(ground.plane_world.has_value());
  const Plane plane = Transformed(capture.world_from_first, *ground.plane_world);
  EXPECT_LT(std::acos(std::min(1.0, plane.normal.z())) * kDegPerRad, tolerance_deg);
  // Height of the plane under the first camera.
  EXPECT_NEAR(plane.SignedDistance(capture.world_from_first.translation_m),
              capture.world_from_first.translation_m.z(),
              tolerance_m);
  for (const GroundObservation& seen : ground.observations) {
    const Pose3 world_from_camera =
        capture.world_from_first * capture.odometry.at(seen.keyframe).world_from_camera;
    EXPECT_NEAR(seen.plane_camera.d_m, world_from_camera.translation_m.z(), 2 * tolerance_m);
    EXPECT_EQ(seen.information.llt().info(), Eigen::Success);
    EXPECT_GT(seen.num_inliers, 0);
  }
}

std::vector<Pose3> Pan(const Eigen::Vector3d& eye,
                       double target_height,
                       double roll_rad = 0,
                       int num_frames = 8) {
  std::vector<Pose3> poses;
  for (int k = 0; k < num_frames; ++k) {
    const double angle = -0.4 + 0.1 * k;
    poses.push_back(LookAt(
        eye,
        eye + Eigen::Vector3d(2 * std::cos(angle), 2 * std::sin(angle), target_height - eye.z()),
        roll_rad));
  }
  return poses;
}

TEST(EstimateGround, FindsTheFloorOfAFurnishedRoom) {
  const TrueCapture capture = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3));
  const Ground ground = Estimate(capture);
  ExpectFloor(capture, ground);
  EXPECT_EQ(ground.observations.size(), capture.frames.size());
}

TEST(EstimateGround, TakesATiltedCamera) {
  const TrueCapture capture = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.2, 0.35));
  ExpectFloor(capture, Estimate(capture));
}

TEST(EstimateGround, ATableTopDoesNotPoseAsTheFloor) {
  BoxWorld world;
  world.boxes = {{{-1.4, -1.2, 0.70}, {0.9, 1.2, 0.74}}};
  // Most frames see nothing but the top and walls above it; the last ones look past it to the
  // floor.
  std::vector<Pose3> poses;
  for (int k = 0; k < 9; ++k) poses.push_back(LookAt({-1.5, 0.05 * k - 0.2, 1.5}, {-0.3, 0, 0.74}));
  for (int k = 0; k < 3; ++k)
    poses.push_back(LookAt({-1.5 + 0.3 * k, 1.0, 1.5}, {0.6 + 0.3 * k, 1.8, 0.0}));
  const TrueCapture capture = Capture(world, poses);
  ExpectFloor(capture, Estimate(capture), 0.02, 1.0);
}

TEST(EstimateGround, CarriesAFloorThatIsSeenLateBackToTheStart) {
  std::vector<Pose3> poses = Pan({-1.7, 0, 1.4}, 1.9, 0, 5);  // walls only
  const std::vector<Pose3> down = Pan({-1.7, 0, 1.4}, 0.2, 0, 4);
  poses.insert(poses.end(), down.begin(), down.end());
  const TrueCapture capture = Capture(BoxWorld{}, poses);
  const Ground ground = Estimate(capture);
  ExpectFloor(capture, ground);
  EXPECT_GE(ground.observations.front().keyframe, FrameIdx{4});
}

TEST(EstimateGround, NearerAndFullerViewsKnowMore) {
  const TrueCapture capture = Capture(
      BoxWorld{}, {LookAt({-1.7, 0, 1.2}, {-0.5, 0, 0}), LookAt({-1.7, 0, 1.2}, {2, 0, 1.1})});
  const Ground ground = Estimate(capture);
  ASSERT_EQ(ground.observations.size(), 2U);
  EXPECT_GT(ground.observations[0].information(2, 2), ground.observations[1].information(2, 2));
}

TEST(EstimateGround, NoGroundIsNoError) {
  // A wall, no depth at all, and a capture without keyframes.
  const TrueCapture wall = Capture(BoxWorld::Wall(), {Pose3{}, Pose3{}});
  EXPECT_FALSE(Estimate(wall).plane_world.has_value());
  TrueCapture dark = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3, 0, 2));
  for (Frame& frame : dark.frames) std::ranges::fill(frame.depth_m, 0.0F);
  EXPECT_FALSE(Estimate(dark).plane_world.has_value());
  TrueCapture unread = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3, 0, 2));
  for (Frame& frame : unread.frames) frame = Frame{};
  EXPECT_FALSE(Estimate(unread).plane_world.has_value());
  EXPECT_FALSE(Estimate(TrueCapture{}).plane_world.has_value());
}

TEST(EstimateGround, OneBadFrameDoesNotHarmTheOthers) {
  TrueCapture capture = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3));
  capture.frames[2] = Frame{};
  for (float& z : capture.frames[4].depth_m) z = std::nanf("");
  const Ground ground = Estimate(capture);
  ExpectFloor(capture, ground);
  EXPECT_EQ(ground.observations.size(), capture.frames.size() - 2);
}

TEST(EstimateGround, IsByteEqualForAnyNumberOfThreads) {
  const TrueCapture capture = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3));
  const auto estimate = [&](int num_threads) {
    const ThreadLimit limit(num_threads);
    return Estimate(capture);
  };
  const Ground one = estimate(1);
  const Ground two = estimate(2);
  EXPECT_EQ(*one.plane_world, *two.plane_world);
  ASSERT_EQ(one.observations.size(), two.observations.size());
  for (std::size_t k = 0; k < one.observations.size(); ++k) {
    EXPECT_EQ(one.observations[k].plane_camera, two.observations[k].plane_camera);
    EXPECT_EQ(one.observations[k].information, two.observations[k].information);
  }
}

}  // namespace
}  // namespace deepslam::ground
