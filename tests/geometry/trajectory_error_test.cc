#include "deepslam/geometry/trajectory_error.h"

#include <cmath>
#include <limits>
#include <numeric>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"
#include "support/pose_matchers.h"

namespace deepslam {
namespace {

using testing::HasSubstr;

Pose3 RandomPose(Random& random, double reach_m, double turn_rad) {
  const auto vector = [&](double size) {
    return Eigen::Vector3d(
        random.Uniform(-size, size), random.Uniform(-size, size), random.Uniform(-size, size));
  };
  return {RotationFromVector(vector(turn_rad)), vector(reach_m)};
}

std::vector<TimedPose> Walk(int num_poses, std::uint64_t seed) {
  Random random(seed);
  std::vector<TimedPose> walk;
  Pose3 at;
  for (int i = 0; i < num_poses; ++i) {
    at = at * RandomPose(random, 0.1, 0.1);
    walk.push_back({i / 30.0, at});
  }
  return walk;
}

std::vector<TimedPose> Disturbed(std::vector<TimedPose> walk, double noise_m, double noise_rad) {
  Random random(77);
  for (TimedPose& pose : walk)
    pose.world_from_camera = pose.world_from_camera * RandomPose(random, noise_m, noise_rad);
  return walk;
}

std::vector<TimedPose> Moved(const Pose3& b_from_a, std::vector<TimedPose> walk) {
  for (TimedPose& pose : walk) pose.world_from_camera = b_from_a * pose.world_from_camera;
  return walk;
}

TEST(TrajectoryError, TruthAgainstItselfIsZero) {
  const std::vector<TimedPose> walk = Walk(50, 1);
  const Result<TrajectoryError> error = ComputeTrajectoryError(walk, walk, {});
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error->num_scored, 50);
  EXPECT_EQ(error->num_relative, 49);
  EXPECT_NEAR(error->ate_m.max, 0, 1e-12);
  EXPECT_NEAR(error->rpe_m.max, 0, 1e-12);
  EXPECT_NEAR(error->rpe_deg.max, 0, 1e-5);
}

TEST(TrajectoryError, RigidMotionOfTheEstimateChangesNothing) {
  const std::vector<TimedPose> truth = Walk(80, 2);
  const std::vector<TimedPose> estimate = Disturbed(truth, 0.02, 0.02);
  const Result<TrajectoryError> plain = ComputeTrajectoryError(estimate, truth, {});
  Random random(5);
  for (int i = 0; i < 10; ++i) {
    const Pose3 motion = RandomPose(random, 50, 3);
    const Result<TrajectoryError> moved =
        ComputeTrajectoryError(Moved(motion, estimate), truth, {});
    EXPECT_NEAR(moved->ate_m.rmse, plain->ate_m.rmse, 1e-9);
    EXPECT_NEAR(moved->ate_m.median, plain->ate_m.median, 1e-9);
    EXPECT_NEAR(moved->rpe_m.rmse, plain->rpe_m.rmse, 1e-9);
    EXPECT_NEAR(moved->rpe_deg.mean, plain->rpe_deg.mean, 1e-6);
    EXPECT_THAT(moved->truth_from_estimate * motion,
                testing_support::PoseNear(plain->truth_from_estimate, 1e-8, 1e-6));
  }
}

TEST(TrajectoryError, ScaleIsNotForgiven) {
  const std::vector<TimedPose> truth = Walk(80, 2);
  std::vector<TimedPose> estimate = truth;
  for (TimedPose& pose : estimate) pose.world_from_camera.translation_m *= 1.1;
  EXPECT_GT(ComputeTrajectoryError(estimate, truth, {})->ate_m.rmse, 0.01);
}

// No rigid motion fits better than the aligned one: checked against small moves around it.
TEST(TrajectoryError, AlignmentIsTheLeastSquaresOptimum) {
  const std::vector<TimedPose> truth = Walk(60, 3);
  const std::vector<TimedPose> estimate = Disturbed(truth, 0.05, 0);
  const Result<TrajectoryError> error = ComputeTrajectoryError(estimate, truth, {});
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Pose3 other = error->truth_from_estimate * RandomPose(random, 0.01, 0.01);
    double sum = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      sum += (other * estimate[k].world_from_camera.translation_m -
              truth[k].world_from_camera.translation_m)
                 .squaredNorm();
    }
    EXPECT_GE(std::sqrt(sum / static_cast<double>(truth.size())), error->ate_m.rmse);
  }
}

TEST(TrajectoryError, StatisticsAreThoseOfTheListedErrors) {
  // A square of truth; the estimate is off by 3, 1, 1 and 3 mm up and down so that alignment cannot
  // help: mirror-symmetric.
  const std::vector<Eigen::Vector3d> corners = {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}};
  std::vector<TimedPose> truth, estimate;
  for (std::size_t i = 0; i < 4; ++i) {
    const double time_s = static_cast<double>(i);
    truth.push_back({time_s, Pose3{Eigen::Quaterniond::Identity(), corners[i]}});
    const double up_m = i % 2 == 0 ? 0.002 : -0.002;
    estimate.push_back(
        {time_s, Pose3{Eigen::Quaterniond::Identity(), corners[i] + Eigen::Vector3d(0, 0, up_m)}});
  }
  const Result<TrajectoryError> error = ComputeTrajectoryError(estimate, truth, {});
  EXPECT_NEAR(error->ate_m.rmse, 0.002, 1e-9);
  EXPECT_NEAR(error->ate_m.median, 0.002, 1e-9);
  EXPECT_NEAR(error->rpe_m.rmse, 0.004, 1e-9);
  EXPECT_NEAR(error->rpe_m.max, 0.004, 1e-9);
}

TEST(TrajectoryError, CountsFramesWithoutTruth) {
  const std::vector<TimedPose> truth = Walk(30, 4);
  std::vector<TimedPose> estimate = Walk(60, 4);
  for (TimedPose& pose : estimate) pose.time_s += 0.004;
  std::reverse(estimate.begin(), estimate.end());
  const Result<TrajectoryError> error = ComputeTrajectoryError(estimate, truth, {});
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error->num_frames, 60);
  EXPECT_EQ(error->num_scored, 30);
  EXPECT_NEAR(error->ate_m.max, 0, 1e-9);
}

TEST(TrajectoryError, ATruePoseScoresOnce) {
  std::vector<TimedPose> truth = Walk(5, 4);
  std::vector<TimedPose> estimate = truth;
  estimate.push_back({truth[2].time_s + 0.003, Pose3{Eigen::Quaterniond::Identity(), {100, 0, 0}}});
  const Result<TrajectoryError> error = ComputeTrajectoryError(estimate, truth, {});
  EXPECT_EQ(error->num_scored, 5);
  EXPECT_NEAR(error->ate_m.max, 0, 1e-9);
}

// Two walks whose times are the same, one behind the other, as a clock set back leaves them.
TEST(TrajectoryError, PairsWithinSegmentsOfTheClock) {
  std::vector<TimedPose> truth = Walk(40, 4);
  for (TimedPose pose : Walk(40, 5)) {
    pose.time_s += 0.1;
    truth.push_back(pose);
  }
  const Result<TrajectoryError> error = ComputeTrajectoryError(truth, truth, {});
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error->num_scored, 80);
  EXPECT_NEAR(error->ate_m.max, 0, 1e-9);
  std::vector<int> in_order(80);
  std::iota(in_order.begin(), in_order.end(), 0);
  EXPECT_EQ(error->scored, in_order);
}

TEST(TrajectoryError, RefusesWhatCannotBeScored) {
  const std::vector<TimedPose> walk = Walk(10, 1);
  std::vector<TimedPose> late = walk;
  for (TimedPose& pose : late) pose.time_s += 1e9;
  EXPECT_THAT(ComputeTrajectoryError(late, walk, {}).error().message, HasSubstr("only 0 of 10"));
  EXPECT_THAT(ComputeTrajectoryError({}, walk, {}).error().message,
              HasSubstr("estimated trajectory holds no poses"));
  EXPECT_THAT(ComputeTrajectoryError(walk, {}, {}).error().message, HasSubstr("true trajectory"));
  std::vector<TimedPose> broken = walk;
  broken[3].world_from_camera.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ComputeTrajectoryError(broken, walk, {}).error().message,
              HasSubstr("pose 3 of the estimated"));
  broken[3].world_from_camera.translation_m.x() = 1e308;  // whose square is not finite
  EXPECT_THAT(ComputeTrajectoryError(broken, walk, {}).error().message,
              HasSubstr("more than 1000 km away"));
}

TEST(TrajectoryError, StraightAndStandingPathsDoNotBreakTheAlignment) {
  std::vector<TimedPose> line, still;
  for (int i = 0; i < 10; ++i) {
    line.push_back({1.0 * i, Pose3{Eigen::Quaterniond::Identity(), {0.1 * i, 0, 0}}});
    still.push_back({1.0 * i, Pose3()});
  }
  EXPECT_NEAR(ComputeTrajectoryError(
                  Moved(Pose3{RotationFromVector({1, 2, 0.5}), {3, 4, 5}}, line), line, {})
                  ->ate_m.rmse,
              0,
              1e-9);
  EXPECT_NEAR(ComputeTrajectoryError(still, still, {})->ate_m.rmse, 0, 1e-12);
}

}  // namespace
}  // namespace deepslam
