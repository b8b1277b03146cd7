#include "deepslam/report/path_jumps.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/core/order_statistics.h"

namespace deepslam::report {
namespace {

// Shorter steps leave what is seen before and after within reach of each other.
constexpr double kJumpM = 0.2;
constexpr double kJumpRad = 20 * kRadPerDeg;  // and smaller turns
// A jump is longer than what all but one step in 20 reach, by what a hand's fastest steps exceed
// those by, ...
constexpr std::size_t kOneStepIn = 20;
constexpr double kBeyondAll = 1.2;  // times that speed
// ... and many times what nine in ten of its likes reach: the quarter of all steps that come
// nearest to it in how much they turn (or move).
constexpr std::size_t kOneLikeIn = 10;
constexpr std::size_t kLikesOneIn = 4;    // of all steps that many are likes
constexpr double kBeyondLikes = 2.5;      // times that speed
constexpr std::size_t kFewestLikes = 20;  // of fewer, nine in ten say little

struct Step {
  PathJump step;
  double speed_m_per_s = 0;
  double turn_rad_per_s = 0;
};

// Of frames that are later than the one before.
double UsualIntervalS(std::span<const TrackedFrame> frames) {
  std::vector<double> intervals_s;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const double time_s = frames[k].time_s - frames[k - 1].time_s;
    if (time_s > 0) intervals_s.push_back(time_s);
  }
  return intervals_s.empty() ? 0 : Median(intervals_s);
}

std::vector<Step> StepsOf(std::span<const TrackedFrame> frames) {
  std::vector<Step> steps;
  const double usual_s = UsualIntervalS(frames);
  for (std::size_t k = 1; k < frames.size(); ++k) {
    double time_s = frames[k].time_s - frames[k - 1].time_s;
    if (time_s < 0) time_s = usual_s;  // the clock was set back
    if (!IsAligned(frames[k - 1]) || !IsAligned(frames[k]) || !(time_s > 0)) continue;
    const Pose3 moved = frames[k - 1].world_from_camera.Inverse() * frames[k].world_from_camera;
    const double length_m = moved.translation_m.norm();
    const double angle_rad = RotationAngle(moved.rotation);
    steps.push_back({{k, length_m, angle_rad, false}, length_m / time_s, angle_rad / time_s});
  }
  return steps;
}

// What all but one in `one_in` of the values reach, beside one that is greater.
double UsualMost(std::vector<double>& values, std::size_t one_in) {
  if (values.size() < 2) return 0;
  const std::size_t last = values.size() - 2;
  return OrderStatistic(values, last - last / one_in);
}

// One of the two speeds of all steps, and which steps are alike in the other one.
class Pace {
 public:
  Pace(std::vector<double> speeds, const std::vector<double>& others)
      : speeds_(std::move(speeds)), by_other_(speeds_.size()), place_(speeds_.size()) {
    std::iota(by_other_.begin(), by_other_.end(), std::size_t{0});
    std::ranges::stable_sort(by_other_, {}, [&](std::size_t k) { return others[k]; });
    for (std::size_t n = 0; n < by_other_.size(); ++n) place_[by_other_[n]] = n;
    std::vector<double> all = speeds_;
    most_ = kBeyondAll * UsualMost(all, kOneStepIn);
  }

  [[nodiscard]] bool IsUnlikeOthers(std::size_t k) const {
    if (speeds_[k] <= most_) return false;
    std::vector<double> likes = LikesOf(k);
    return speeds_[k] > kBeyondLikes * UsualMost(likes, kOneLikeIn);
  }

 private:
  // Itself among them.
  [[nodiscard]] std::vector<double> LikesOf(std::size_t k) const {
    const std::size_t count =
        std::min(speeds_.size(), std::max(kFewestLikes, speeds_.size() / kLikesOneIn));
    const std::size_t before = std::min(place_[k], count / 2);
    const std::size_t first = std::min(place_[k] - before, speeds_.size() - count);
    std::vector<double> likes;
    for (std::size_t n = first; n < first + count; ++n) likes.push_back(speeds_[by_other_[n]]);
    return likes;
  }

  std::vector<double> speeds_;
  std::vector<std::size_t> by_other_;  // steps, by the other speed
  std::vector<std::size_t> place_;     // of each step among them
  double most_ = 0;
};

}  // namespace

std::vector<PathJump> FindPathJumps(std::span<const TrackedFrame> frames) {
  const std::vector<Step> steps = StepsOf(frames);
  std::vector<double> speeds, turns;
  for (const Step& step : steps) {
    speeds.push_back(step.speed_m_per_s);
    turns.push_back(step.turn_rad_per_s);
  }
  const Pace moving(speeds, turns);
  const Pace turning(turns, speeds);
  std::vector<PathJump> jumps;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    PathJump jump = steps[k].step;
    const bool is_move = jump.length_m >= kJumpM && moving.IsUnlikeOthers(k);
    jump.is_turn = !is_move && jump.angle_rad >= kJumpRad && turning.IsUnlikeOthers(k);
    if (is_move || jump.is_turn) jumps.push_back(jump);
  }
  return jumps;
}

}  // namespace deepslam::report
