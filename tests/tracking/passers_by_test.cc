// People who walk past the camera do not take it along.
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tracking/tracked_sequence.h"

namespace deepslam::tracking {
namespace {

// A person: legs, trunk and head, standing on the floor at the origin.
std::vector<Box3> Person() {
  return {{{-0.20, -0.10, 0.0}, {-0.05, 0.10, 0.8}},
          {{0.05, -0.10, 0.0}, {0.20, 0.10, 0.8}},
          {{-0.25, -0.15, 0.8}, {0.25, 0.15, 1.5}},
          {{-0.10, -0.10, 1.5}, {0.10, 0.10, 1.75}}};
}

double ShareOfWalker(const BoxWorld& world, const Pose3& world_from_camera) {
  int count = 0;
  for (int v = 0; v < kSmallCamera.height; ++v) {
    for (int u = 0; u < kSmallCamera.width; ++u) {
      const Eigen::Vector3d ray = world_from_camera.rotation * kSmallCamera.Ray(u, v);
      const double walker = world.CastWalker(world_from_camera.translation_m, ray);
      count += walker <= world.Cast(world_from_camera.translation_m, ray) ? 1 : 0;
    }
  }
  return static_cast<double>(count) / (kSmallCamera.width * kSmallCamera.height);
}

struct Walk {
  std::string name;
  double camera_step_deg;  // of the camera, per frame
  double pace_m;           // of the person, per frame: to the right where positive
  double distance_m;       // of the person from the camera in the middle
  double covered_share;    // of the view, at least, when most is
};

void PrintTo(const Walk& walk, std::ostream* out) { *out << walk.name; }

struct WalkPast {
  std::vector<Pose3> truth;
  std::vector<Frame> frames;
  double largest_share = 0;
  int num_seen = 0;  // frames in which the person is
};

WalkPast RenderWalkPast(const Walk& walk) {
  constexpr int kNumFrames = 70;
  WalkPast past;
  past.truth = Arc(kNumFrames, walk.camera_step_deg);
  const Pose3& middle = past.truth[kNumFrames / 2];
  BoxWorld world = BoxWorld::Furnished();
  world.walker = Person();
  for (std::size_t k = 0; k < past.truth.size(); ++k) {
    const double aside_m = walk.pace_m * (static_cast<double>(k) - kNumFrames / 2);
    world.walked_m = middle * Eigen::Vector3d(aside_m, 0, walk.distance_m);
    world.walked_m.z() = 0;
    const double share = ShareOfWalker(world, past.truth[k]);
    past.largest_share = std::max(past.largest_share, share);
    past.num_seen += share > 0 ? 1 : 0;
    past.frames.push_back(RenderFrame(world, past.truth[k], 1.0, k));
    past.frames.back().time_s = 0.05 * static_cast<double>(k);
  }
  return past;
}

class EstimateOdometryWalker : public ::testing::TestWithParam<Walk> {};

// Someone walks by and covers a third of the view, more than half, two thirds.
TEST_P(EstimateOdometryWalker, DoesNotTakeTheCameraAlong) {
  const WalkPast walk = RenderWalkPast(GetParam());
  const std::size_t num_frames = walk.frames.size();
  ASSERT_GT(walk.largest_share, GetParam().covered_share);
  ASSERT_GE(walk.num_seen, 20);  // a second
  ASSERT_LT(walk.num_seen, static_cast<int>(num_frames) - 15);
  const Odometry odometry = Track(walk.frames);
  ExpectStatus(odometry, 0, num_frames, TrackingStatus::kTracked);
  // Half the person's step.
  ExpectTrue(odometry, walk.truth, 0, num_frames, 0.03, 0.6);
  ExpectConsistent(odometry);
  ExpectHonestEdges(odometry, walk.truth);
}

INSTANTIATE_TEST_SUITE_P(
    Passes,
    EstimateOdometryWalker,
    ::testing::Values(Walk{"AStandingCamera", 0.0, 0.06, 1.2, 0.30},
                      Walk{"AMovingCamera", 0.5, 0.06, 1.2, 0.30},
                      Walk{"AMovingCameraTheOtherWay", 0.5, -0.06, 1.2, 0.30},
                      Walk{"AFastCamera", 1.0, 0.06, 1.2, 0.30},
                      Walk{"AStandingCameraNearBy", 0.0, 0.06, 0.8, 0.50},
                      Walk{"AMovingCameraNearBy", 0.5, 0.06, 0.8, 0.50},
                      Walk{"AMovingCameraTheOtherWayNearBy", 0.5, -0.06, 0.8, 0.50},
                      Walk{"AFastCameraNearBy", 1.0, 0.06, 0.8, 0.50},
                      Walk{"AStandingCameraNearer", 0.0, 0.06, 0.65, 0.60}),
    [](const auto& test) { return test.param.name; });

// What can be told of the camera while next to nothing but a passer-by is in view is that it is
// lost; the rest lies where it belongs.
class EstimateOdometryHiddenView : public EstimateOdometryWalker {};

TEST_P(EstimateOdometryHiddenView, SaysWhichFramesAreLost) {
  const WalkPast walk = RenderWalkPast(GetParam());
  ASSERT_GT(walk.largest_share, GetParam().covered_share);
  const Odometry odometry = Track(walk.frames);
  for (std::size_t k = 0; k < walk.truth.size(); ++k) {
    if (odometry.frames[k].status != TrackingStatus::kTracked) continue;
    EXPECT_THAT(
        (walk.truth[0].Inverse() * walk.truth[k]).Inverse() * odometry.frames[k].world_from_camera,
        PoseNear(Pose3{}, 0.05, 1.5))
        << "frame " << k;
  }
  ExpectTrue(odometry, walk.truth, 0, walk.truth.size() / 2 - 6);
  ExpectTrue(odometry, walk.truth, walk.truth.size() - 10, walk.truth.size());
  ExpectConsistent(odometry);
}

INSTANTIATE_TEST_SUITE_P(Passes,
                         EstimateOdometryHiddenView,
                         ::testing::Values(Walk{"AStandingCamera", 0.0, 0.06, 0.5, 0.90},
                                           Walk{"AMovingCamera", 0.5, 0.06, 0.5, 0.85},
                                           Walk{"AStandingCameraAllCovered", 0.0, 0.06, 0.4, 0.99},
                                           Walk{"AMovingCameraAllCovered", 0.5, 0.06, 0.4, 0.95}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace deepslam::tracking
