#include "deepslam/synth/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "deepslam/core/angles.h"
#include "deepslam/core/random.h"

namespace deepslam::synth {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStepsPerS = 1.8;  // of a person walking

// A stationary smooth signal of unit variance: four waves around the frequencies of a hand and a
// step.
class Sway {
 public:
  explicit Sway(Random random) {
    for (std::size_t i = 0; i < frequency_hz_.size(); ++i) {
      frequency_hz_[i] = random.Uniform(0.25, 1.6);
      phase_rad_[i] = random.Uniform(0, 2 * kPi);
    }
  }
  [[nodiscard]] double At(double time_s) const {
    double sum = 0;
    for (std::size_t i = 0; i < frequency_hz_.size(); ++i) {
      sum += std::sin(2 * kPi * frequency_hz_[i] * time_s + phase_rad_[i]);
    }
    return sum / std::sqrt(0.5 * static_cast<double>(frequency_hz_.size()));
  }

 private:
  std::array<double, 4> frequency_hz_{};
  std::array<double, 4> phase_rad_{};
};

// Camera axes x right, y down, z forward in a world with z up.
Eigen::Quaterniond LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d forward = (to - from).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d world_from_camera;
  world_from_camera << right, forward.cross(right), forward;
  return Eigen::Quaterniond(world_from_camera).normalized();
}

// Half-way between even speed and a full stop at both ends.
double Eased(double linear) { return 0.5 * linear + 0.5 * (0.5 - 0.5 * std::cos(kPi * linear)); }

// A smooth curve through points, by the share of its length.
class Curve {
 public:
  // `span_length_m`: of a piece between two shares of a span, given both ends.
  template <typename SpanLength>
  Curve(const std::vector<Eigen::Vector3d>& points, bool closed, const SpanLength& span_length_m)
      : points_(points), closed_(closed) {
    num_spans_ = closed ? points.size() : points.size() - 1;
    length_m_.push_back(0);
    double last = 0;
    for (std::size_t i = 1; i <= num_spans_ * kStepsPerSpan; ++i) {
      const double span = static_cast<double>(i) / kStepsPerSpan;
      length_m_.push_back(length_m_.back() + span_length_m(*this, last, span));
      last = span;
    }
  }
  Curve(const std::vector<Eigen::Vector3d>& points, bool closed)
      : Curve(points, closed, [](const Curve& curve, double from, double to) {
          return (curve.AtSpan(to) - curve.AtSpan(from)).norm();
        }) {}

  // Span and share of it, as one number, at a share of the length. Closed curves go on after 1.
  [[nodiscard]] double SpanAt(double share) const {
    const double whole = closed_ ? std::floor(share) : 0;
    const double wanted_m = std::clamp(share - whole, 0.0, 1.0) * length_m_.back();
    const auto next = std::upper_bound(length_m_.begin() + 1, length_m_.end() - 1, wanted_m);
    const auto i = static_cast<std::size_t>(next - length_m_.begin()) - 1;
    const double step_m = length_m_[i + 1] - length_m_[i];
    const double within = step_m > 0 ? (wanted_m - length_m_[i]) / step_m : 0;
    return (static_cast<double>(i) + std::clamp(within, 0.0, 1.0)) / kStepsPerSpan;
  }

  // Catmull-Rom, uniform.
  [[nodiscard]] Eigen::Vector3d AtSpan(double span) const {
    const double whole = std::min(std::floor(span), static_cast<double>(num_spans_) - 1);
    const double t = span - whole;
    const auto i = static_cast<long>(whole);
    const Eigen::Vector3d a = Point(i - 1), b = Point(i), c = Point(i + 1), d = Point(i + 2);
    return 0.5 * (2 * b + t * (c - a) + t * t * (2 * a - 5 * b + 4 * c - d) +
                  t * t * t * (3 * b - a - 3 * c + d));
  }
  [[nodiscard]] double length_m() const { return length_m_.back(); }

 private:
  // Of the table of lengths; within a step the curve counts as straight.
  static constexpr std::size_t kStepsPerSpan = 64;

  [[nodiscard]] Eigen::Vector3d Point(long i) const {
    const auto n = static_cast<long>(points_.size());
    return points_[static_cast<std::size_t>(closed_ ? (i % n + n) % n : std::clamp(i, 0L, n - 1))];
  }

  const std::vector<Eigen::Vector3d>& points_;
  bool closed_;
  std::size_t num_spans_ = 0;
  std::vector<double> length_m_;
};

struct Look {
  Eigen::Vector3d place;
  Eigen::Vector3d target;
};

Look OrbitAt(const SceneOrbit& orbit, double linear) {
  const double angle_rad = (orbit.start_deg + orbit.sweep_deg * Eased(linear)) * kRadPerDeg;
  return {{orbit.centre_m.x() + orbit.radius_m * std::cos(angle_rad),
           orbit.centre_m.y() + orbit.radius_m * std::sin(angle_rad),
           orbit.height_m},
          {orbit.centre_m.x(), orbit.centre_m.y(), orbit.target_height_m}};
}

// Its points, by the share of the time that walking and turning take.
Curve WayOf(const SceneWalk& walk) {
  if (walk.turn_m_per_rad <= 0 || walk.look_at_m.size() < 2) return {walk.points_m, walk.closed};
  const Curve targets(walk.look_at_m, walk.closed);
  return {walk.points_m, walk.closed, [&](const Curve& curve, double from, double to) {
            const Eigen::Vector3d a = curve.AtSpan(from), b = curve.AtSpan(to);
            const double turn_rad = RotationAngle(LookAt(a, targets.AtSpan(from)).inverse() *
                                                  LookAt(b, targets.AtSpan(to)));
            return std::max((b - a).norm(), walk.turn_m_per_rad * turn_rad);
          }};
}

Look WalkAt(const SceneWalk& walk, const Curve& curve, double linear) {
  constexpr double kAheadM = 1.5;  // along the way, at which the camera looks
  double share = walk.closed ? walk.laps * linear : Eased(linear);
  if (walk.and_back) {
    const double there = 1 - std::abs(1 - 2 * linear);
    share = walk.closed ? walk.laps * there : Eased(there);
  }
  const double span = curve.SpanAt(share);
  Look look{curve.AtSpan(span), Eigen::Vector3d::Zero()};
  if (walk.look_at_m.size() == 1) {
    look.target = walk.look_at_m[0];
  } else if (!walk.look_at_m.empty()) {
    look.target = Curve(walk.look_at_m, walk.closed).AtSpan(span);
  } else {
    const double ahead = share + kAheadM / std::max(kAheadM, curve.length_m());
    look.target = curve.AtSpan(curve.SpanAt(ahead));
    if (!walk.closed && ahead > 1) {
      // Past the end the way goes straight on.
      const Eigen::Vector3d before = curve.AtSpan(curve.SpanAt(0.98));
      const Eigen::Vector3d end = curve.AtSpan(curve.SpanAt(1));
      look.target = end + (ahead - 1) * curve.length_m() * (end - before).normalized();
    }
    look.target.z() = walk.ahead_height_m;
  }
  return look;
}

}  // namespace

double WalkLength_m(const SceneWalk& walk) { return WayOf(walk).length_m(); }

std::vector<Pose3> CameraPath(const SceneDescription& description) {
  const SceneWalk& walk = description.walk;
  const bool walks = !walk.points_m.empty();
  const double shake_m = walks ? walk.shake_m : description.orbit.shake_m;
  const double shake_deg = walks ? walk.shake_deg : description.orbit.shake_deg;
  std::vector<Sway> sways;
  for (std::uint64_t i = 0; i < 6; ++i) sways.emplace_back(Random(description.seed, "sway", i));
  std::optional<Curve> curve;
  if (walks) curve.emplace(WayOf(walk));
  const Eigen::Quaterniond held =
      RotationFromVector(description.roll_deg * kRadPerDeg * Eigen::Vector3d::UnitZ());
  std::vector<Pose3> path;
  for (int i = 0; i < description.num_frames; ++i) {
    const double time_s = i / description.frames_per_s;
    const double linear =
        description.num_frames > 1 ? static_cast<double>(i) / (description.num_frames - 1) : 0;
    const Look look = walks ? WalkAt(walk, *curve, linear) : OrbitAt(description.orbit, linear);
    Eigen::Vector3d sway_m =
        shake_m * Eigen::Vector3d(sways[0].At(time_s), sways[1].At(time_s), sways[2].At(time_s));
    if (walks) sway_m.z() += walk.step_m * std::sqrt(2.0) * std::sin(2 * kPi * kStepsPerS * time_s);
    const Eigen::Vector3d sway_rad =
        shake_deg * kRadPerDeg *
        Eigen::Vector3d(sways[3].At(time_s), sways[4].At(time_s), sways[5].At(time_s));
    path.push_back(
        {(LookAt(look.place, look.target) * RotationFromVector(sway_rad) * held).normalized(),
         look.place + sway_m});
  }
  return path;
}

std::vector<int> KeptFrames(const SceneDescription& description) {
  Random random(description.seed, "dropped", 0);
  std::vector<int> kept;
  for (int i = 0; i < description.num_frames; ++i) {
    const bool dropped = random.Uniform() < description.faults.dropped_share;
    if (!dropped || i == 0) kept.push_back(i);
  }
  return kept;
}

double ExposureGain(const SceneDescription& description, double time_s) {
  constexpr double kSlower = 0.15;  // 0.04 to 0.24 Hz, where a hand sways at 0.25 to 1.6
  const Sway drift(Random(description.seed, "exposure", 0));
  return std::exp2(description.faults.exposure_change_stops * drift.At(kSlower * time_s));
}

}  // namespace deepslam::synth
