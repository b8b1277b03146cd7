#include "deepslam/synth/camera_path.h"

#include <array>
#include <cmath>
#include <numbers>

#include "deepslam/core/random.h"

namespace deepslam::synth {
namespace {

constexpr double kPi = std::numbers::pi;

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

}  // namespace

std::vector<Pose3> CameraPath(const SceneDescription& description) {
  const SceneOrbit& orbit = description.orbit;
  std::vector<Sway> sways;
  for (std::uint64_t i = 0; i < 6; ++i) sways.emplace_back(Random(description.seed, "sway", i));
  const Eigen::Vector3d target(orbit.centre_m.x(), orbit.centre_m.y(), orbit.target_height_m);
  std::vector<Pose3> path;
  for (int i = 0; i < description.num_frames; ++i) {
    const double time_s = i / description.frames_per_s;
    const double linear =
        description.num_frames > 1 ? static_cast<double>(i) / (description.num_frames - 1) : 0;
    // Half-way between even speed and a full stop at both ends.
    const double eased = 0.5 * linear + 0.5 * (0.5 - 0.5 * std::cos(kPi * linear));
    const double angle_rad = (orbit.start_deg + orbit.sweep_deg * eased) * kPi / 180.0;
    const Eigen::Vector3d place(orbit.centre_m.x() + orbit.radius_m * std::cos(angle_rad),
                                orbit.centre_m.y() + orbit.radius_m * std::sin(angle_rad),
                                orbit.height_m);
    const Eigen::Vector3d sway_m =
        orbit.shake_m *
        Eigen::Vector3d(sways[0].At(time_s), sways[1].At(time_s), sways[2].At(time_s));
    const Eigen::Vector3d sway_rad =
        orbit.shake_deg * kPi / 180.0 *
        Eigen::Vector3d(sways[3].At(time_s), sways[4].At(time_s), sways[5].At(time_s));
    path.push_back(
        {(LookAt(place, target) * RotationFromVector(sway_rad)).normalized(), place + sway_m});
  }
  return path;
}

}  // namespace deepslam::synth
