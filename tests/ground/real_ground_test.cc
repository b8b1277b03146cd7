// Ground on the real captures, with the poses that came with them, so that only the ground is
// scored.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "deepslam/ground/ground_plane.h"
#include "deepslam/layouts/open_capture.h"
#include "deepslam/tracking/odometry.h"
#include "support/test_data.h"

namespace deepslam::ground {
namespace {

struct Estimated {
  dataset::Capture capture;
  Odometry odometry;
  Ground ground;
};

Estimated Estimate(const std::filesystem::path& folder) {
  SilentProgress progress;
  Result<dataset::Capture> capture = layouts::OpenCapture(folder);
  Estimated result{std::move(capture).value(), {}, {}};
  Result<Odometry> odometry = tracking::OdometryFromCapturePoses(
      *result.capture.frames, tracking::OdometryOptions{}, progress);
  result.odometry = std::move(odometry).value();
  Result<Ground> ground =
      EstimateGround(*result.capture.frames, result.odometry, GroundOptions{}, progress);
  result.ground = std::move(ground).value();
  return result;
}

TEST(RealGround, HeightsAboveTheFloorOfACabinetCaptureAreTrue) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const Estimated estimated = Estimate(data / "data" / "fr3_cabinet");
  ASSERT_TRUE(estimated.ground.plane_world.has_value());
  // Motion capture: the floor is z = 0 of its world.
  std::vector<double> errors_m;
  for (const GroundObservation& seen : estimated.ground.observations) {
    const Pose3 world_from_camera =
        *estimated.capture.frames->capture_world_from_camera(seen.keyframe);
    errors_m.push_back(std::abs(seen.plane_camera.d_m - world_from_camera.translation_m.z()));
  }
  EXPECT_GT(errors_m.size(), 35U);
  std::ranges::sort(errors_m);
  EXPECT_LT(errors_m[errors_m.size() / 2], 0.02);
  EXPECT_LT(errors_m.back(), 0.06);
}

TEST(RealGround, TheKitchenFloorIsSeenThoughATableIsInFront) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const Estimated estimated = Estimate(data / "data" / "redkitchen");
  ASSERT_TRUE(estimated.ground.plane_world.has_value());
  EXPECT_GE(estimated.ground.observations.size(), 5U);
  // The table top is 0.74 m above the floor and the camera well above it.
  EXPECT_GT(estimated.ground.plane_world->d_m, 1.2);
  EXPECT_LT(estimated.ground.plane_world->d_m, 1.6);
}

// From here on the table fills the pictures, and no keyframe shows more than a fiftieth of floor.
constexpr FrameIdx kFirstWithoutFloor{250};

TEST(RealGround, TheKitchenFloorIsFoundWhereNoPictureShowsMuchOfIt) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const Estimated whole = Estimate(data / "data" / "redkitchen");
  ASSERT_TRUE(whole.ground.plane_world.has_value());
  Odometry late = whole.odometry;
  std::erase_if(late.keyframes, [](FrameIdx k) { return k < kFirstWithoutFloor; });
  std::erase_if(late.edges, [](const RelativePose& edge) {
    return edge.i < kFirstWithoutFloor || edge.j < kFirstWithoutFloor;
  });
  SilentProgress progress;
  const Result<Ground> ground =
      EstimateGround(*whole.capture.frames, late, GroundOptions{}, progress);
  ASSERT_TRUE(ground.ok() && ground->plane_world.has_value());
  const double cosine = ground->plane_world->normal.dot(whole.ground.plane_world->normal);
  EXPECT_GT(cosine, 0.9994) << "2 degrees";
  for (const GroundObservation& seen : ground->observations) {
    const Pose3& pose = late.at(seen.keyframe).world_from_camera;
    EXPECT_NEAR(
        seen.plane_camera.d_m, whole.ground.plane_world->SignedDistance(pose.translation_m), 0.1);
  }
}

}  // namespace
}  // namespace deepslam::ground
