#include "deepslam/geometry/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include <Eigen/SVD>

#include "deepslam/core/angles.h"
#include "deepslam/core/clock_segments.h"
#include "deepslam/geometry/max_position.h"

namespace deepslam {
namespace {

ErrorStatistics Statistics(std::vector<double> values) {
  ErrorStatistics statistics;
  if (values.empty()) return statistics;
  double sum = 0;
  double sum_squares = 0;
  for (const double v : values) {
    sum += v;
    sum_squares += v * v;
  }
  const auto count = static_cast<double>(values.size());
  statistics.mean = sum / count;
  statistics.rmse = std::sqrt(sum_squares / count);
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  statistics.median =
      values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  statistics.max = values.back();
  return statistics;
}

std::optional<Error> Fault(const std::vector<TimedPose>& poses, const std::string& name) {
  if (poses.empty()) return InvalidInput("the " + name + " trajectory holds no poses");
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose3& pose = poses[i].world_from_camera;
    if (std::isfinite(poses[i].time_s) && pose.translation_m.allFinite() &&
        pose.translation_m.cwiseAbs().maxCoeff() <= kMaxPositionM &&
        pose.rotation.coeffs().allFinite() && pose.rotation.norm() > 0.5) {
      continue;
    }
    return InvalidInput("pose " + std::to_string(i) + " of the " + name +
                        " trajectory is not finite, is more than 1000 km away or has no rotation");
  }
  return std::nullopt;
}

struct Pair {
  std::size_t estimate = 0;
  std::size_t truth = 0;
};

// Indices of poses by ascending time, of each segment of the clock.
std::vector<std::vector<std::size_t>> OrderByTime(const std::vector<TimedPose>& poses,
                                                  const std::vector<int>& segments) {
  std::vector<std::vector<std::size_t>> orders(static_cast<std::size_t>(segments.back()) + 1);
  for (std::size_t i = 0; i < poses.size(); ++i)
    orders[static_cast<std::size_t>(segments[i])].push_back(i);
  for (std::vector<std::size_t>& order : orders)
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return poses[i].time_s; });
  return orders;
}

std::vector<int> SegmentsOf(const std::vector<TimedPose>& poses) {
  std::vector<double> times_s;
  for (const TimedPose& pose : poses) times_s.push_back(pose.time_s);
  return ClockSegments(times_s);
}

// In ascending time. Where several poses of one list want the same of the other, the nearest in
// time has it.
std::vector<Pair> PairByTime(const std::vector<TimedPose>& estimate,
                             const std::vector<std::size_t>& estimate_order,
                             const std::vector<TimedPose>& truth,
                             const std::vector<std::size_t>& truth_order,
                             double max_difference_s) {
  std::vector<Pair> pairs;
  double last_difference_s = 0;
  for (const std::size_t e : estimate_order) {
    const double time_s = estimate[e].time_s;
    const auto after = std::lower_bound(
        truth_order.begin(), truth_order.end(), time_s, [&](std::size_t t, double value) {
          return truth[t].time_s < value;
        });
    std::optional<std::size_t> nearest;
    double difference_s = std::numeric_limits<double>::infinity();
    for (const auto candidate : {after == truth_order.begin() ? after : after - 1, after}) {
      if (candidate == truth_order.end()) continue;
      const double d = std::abs(truth[*candidate].time_s - time_s);
      if (d < difference_s) {
        difference_s = d;
        nearest = *candidate;
      }
    }
    if (!nearest || difference_s > max_difference_s) continue;
    if (!pairs.empty() && pairs.back().truth == *nearest) {
      if (difference_s >= last_difference_s) continue;
      pairs.pop_back();
    }
    pairs.push_back({e, *nearest});
    last_difference_s = difference_s;
  }
  return pairs;
}

// The same times may stand for several moments where a clock was set back.
std::vector<Pair> PairByClockSegment(const std::vector<TimedPose>& estimate,
                                     const std::vector<TimedPose>& truth,
                                     double max_difference_s) {
  std::vector<int> estimate_segments = SegmentsOf(estimate);
  std::vector<int> truth_segments = SegmentsOf(truth);
  if (estimate_segments.back() != truth_segments.back()) {
    std::ranges::fill(estimate_segments, 0);
    std::ranges::fill(truth_segments, 0);
  }
  const auto estimate_orders = OrderByTime(estimate, estimate_segments);
  const auto truth_orders = OrderByTime(truth, truth_segments);
  std::vector<Pair> pairs;
  for (std::size_t s = 0; s < estimate_orders.size(); ++s) {
    const std::vector<Pair> more =
        PairByTime(estimate, estimate_orders[s], truth, truth_orders[s], max_difference_s);
    pairs.insert(pairs.end(), more.begin(), more.end());
  }
  return pairs;
}

Pose3 Normalised(const Pose3& pose) { return {pose.rotation.normalized(), pose.translation_m}; }

}  // namespace

void Describe(OptionsVisitor& visitor, TrajectoryErrorOptions& options) {
  visitor.Field("max_time_difference_s",
                options.max_time_difference_s,
                {0, 10},
                "s",
                "largest time between an estimated pose and its true one");
  visitor.Field("rpe_delta",
                options.rpe_delta,
                {1, 100000},
                "1",
                "scored frames between the two ends of a relative pose");
}

Pose3 AlignRigidly(const std::vector<Eigen::Vector3d>& points_a,
                   const std::vector<Eigen::Vector3d>& points_b) {
  DEEPSLAM_CHECK(points_a.size() == points_b.size() && !points_a.empty(), "points come in pairs");
  if (points_a == points_b) return Pose3();
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points_a.size(); ++i) {
    mean_a += points_a[i];
    mean_b += points_b[i];
  }
  mean_a /= static_cast<double>(points_a.size());
  mean_b /= static_cast<double>(points_b.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points_a.size(); ++i) {
    covariance += (points_b[i] - mean_b) * (points_a[i] - mean_a).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d reflection = Eigen::Matrix3d::Identity();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) reflection(2, 2) = -1;
  const Eigen::Matrix3d rotation = svd.matrixU() * reflection * svd.matrixV().transpose();
  return {Eigen::Quaterniond(rotation).normalized(), mean_b - rotation * mean_a};
}

Result<TrajectoryError> ComputeTrajectoryError(std::vector<TimedPose> estimate,
                                               std::vector<TimedPose> truth,
                                               const TrajectoryErrorOptions& options) {
  if (const std::optional<Error> fault = Fault(estimate, "estimated")) return *fault;
  if (const std::optional<Error> fault = Fault(truth, "true")) return *fault;
  const std::vector<Pair> pairs =
      PairByClockSegment(estimate, truth, options.max_time_difference_s);
  if (pairs.size() < 3) {
    return InvalidInput("only " + std::to_string(pairs.size()) + " of " +
                        std::to_string(estimate.size()) + " poses have a true pose within " +
                        std::to_string(options.max_time_difference_s) +
                        " s; at least 3 are needed: do both trajectories use the same clock?");
  }
  TrajectoryError error;
  error.num_frames = static_cast<int>(estimate.size());
  error.num_scored = static_cast<int>(pairs.size());
  std::vector<Eigen::Vector3d> estimated_m;
  std::vector<Eigen::Vector3d> true_m;
  for (const Pair& pair : pairs) {
    error.scored.push_back(static_cast<int>(pair.estimate));
    estimated_m.push_back(estimate[pair.estimate].world_from_camera.translation_m);
    true_m.push_back(truth[pair.truth].world_from_camera.translation_m);
  }
  error.truth_from_estimate = AlignRigidly(estimated_m, true_m);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    error.position_error_m.push_back(
        (error.truth_from_estimate * estimated_m[i] - true_m[i]).norm());
  }
  error.ate_m = Statistics(error.position_error_m);

  std::vector<double> relative_m;
  std::vector<double> relative_deg;
  const auto delta = static_cast<std::size_t>(std::max(1, options.rpe_delta));
  for (std::size_t i = 0; i + delta < pairs.size(); ++i) {
    const auto relative =
        [&](const std::vector<TimedPose>& poses, std::size_t from, std::size_t to) {
          return Normalised(poses[from].world_from_camera).Inverse() *
                 Normalised(poses[to].world_from_camera);
        };
    const Pose3 difference = relative(truth, pairs[i].truth, pairs[i + delta].truth).Inverse() *
                             relative(estimate, pairs[i].estimate, pairs[i + delta].estimate);
    relative_m.push_back(difference.translation_m.norm());
    relative_deg.push_back(RotationAngle(difference.rotation) * kDegPerRad);
  }
  error.num_relative = static_cast<int>(relative_m.size());
  error.rpe_m = Statistics(std::move(relative_m));
  error.rpe_deg = Statistics(std::move(relative_deg));
  return error;
}

}  // namespace deepslam
