// Tracking of the real captures against the poses that came with them.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/layouts/open_capture.h"
#include "deepslam/tracking/odometry.h"
#include "support/test_data.h"

namespace deepslam::tracking {
namespace {

// Absolute trajectory error after rigid alignment (Umeyama without scale), all frames.
double AteM(const FrameSource& frames, const Odometry& odometry) {
  Eigen::Matrix3Xd estimated(3, frames.num_frames());
  Eigen::Matrix3Xd truth(3, frames.num_frames());
  for (const TrackedFrame& frame : odometry.frames) {
    estimated.col(frame.frame.value) = frame.world_from_camera.translation_m;
    truth.col(frame.frame.value) = frames.capture_world_from_camera(frame.frame)->translation_m;
  }
  const Eigen::Matrix4d aligned = Eigen::umeyama(estimated, truth, false);
  const Eigen::Matrix3Xd moved = (aligned.topLeftCorner<3, 3>() * estimated).colwise() +
                                 Eigen::Vector3d(aligned.topRightCorner<3, 1>());
  return std::sqrt((moved - truth).colwise().squaredNorm().mean());
}

int NumAligned(const Odometry& odometry) {
  return static_cast<int>(std::ranges::count_if(odometry.frames, [](const TrackedFrame& frame) {
    return frame.status == TrackingStatus::kTracked || frame.status == TrackingStatus::kDegenerate;
  }));
}

TEST(RealOdometry, FollowsTheKitchenWithoutLosingAFrame) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const auto capture = layouts::OpenCapture(data / "data" / "redkitchen");
  ASSERT_TRUE(capture.ok());
  SilentProgress progress;
  const auto odometry = EstimateOdometry(*capture->frames, OdometryOptions{}, progress);
  ASSERT_TRUE(odometry.ok());
  EXPECT_EQ(odometry->frames.size(), 500U);
  EXPECT_EQ(NumAligned(*odometry), 500);
  // The reference itself is good to 2-3 cm; 3 are asked of the refined path (real_capture_test.py).
  EXPECT_LT(AteM(*capture->frames, *odometry), 0.04);
}

TEST(RealOdometry, FollowsBigStepsRoundAPlainCabinet) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const auto capture = layouts::OpenCapture(data / "data" / "fr3_cabinet");
  ASSERT_TRUE(capture.ok());
  SilentProgress progress;
  const auto odometry = EstimateOdometry(*capture->frames, OdometryOptions{}, progress);
  ASSERT_TRUE(odometry.ok());
  EXPECT_EQ(NumAligned(*odometry), 58);
  EXPECT_LT(AteM(*capture->frames, *odometry), 0.03);
}

}  // namespace
}  // namespace deepslam::tracking
