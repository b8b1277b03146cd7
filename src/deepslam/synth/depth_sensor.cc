#include "deepslam/synth/depth_sensor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace deepslam::synth {
namespace {

// The formulas grow without bound towards a face seen from its edge, where there is no depth.
constexpr double kMaxTheta = 1.45;

DepthSensor KinectV1() {
  DepthSensor sensor;
  sensor.name = "kinect_v1";
  sensor.camera = {640, 480, 525.0, 525.0, 319.5, 239.5};
  sensor.min_range_m = 0.45;
  sensor.max_range_m = 6.0;
  sensor.axial_constant_m = 0.0012;
  sensor.axial_quadratic_per_m = 0.0019;
  sensor.axial_around_m = 0.4;
  sensor.axial_angle_m = 0.0001;
  sensor.axial_angle_power = -0.5;
  sensor.lateral_px = 0.8;
  sensor.lateral_angle_px = 0.035;
  sensor.noise_reach_px = 4;
  sensor.rim = {0.012, 0.05, 0.025, 0.025};
  sensor.baseline_m = 0.075;
  sensor.left_eye_m = 0.05;
  sensor.right_eye_m = 0.025;
  sensor.disparity_focal_px = 580;
  sensor.disparity_step_px = 0.125;
  sensor.bias_quadratic_per_m = 0.001;
  sensor.mixed_share = 0.1;
  sensor.signal_lost = 0.0008;
  sensor.signal_sure = 0.0025;
  return sensor;
}

DepthSensor KinectV2() {
  DepthSensor sensor;
  sensor.name = "kinect_v2";
  sensor.camera = {512, 424, 365.5, 365.5, 255.5, 211.5};
  sensor.min_range_m = 0.5;
  sensor.max_range_m = 8.0;
  sensor.axial_constant_m = 0.0015;
  sensor.axial_linear = -0.0005;
  sensor.axial_quadratic_per_m = 0.0003;
  sensor.axial_angle_m = 0.0001;
  sensor.axial_angle_power = 1.5;
  sensor.lateral_px = 0.3;
  sensor.bias_constant_m = 0.004;
  sensor.mixed_share = 0.7;
  sensor.signal_lost = 0.0015;
  sensor.signal_sure = 0.004;
  return sensor;
}

DepthSensor D435() {
  DepthSensor sensor;
  sensor.name = "d435";
  sensor.camera = {640, 480, 615.0, 615.0, 319.5, 239.5};
  sensor.min_range_m = 0.28;
  sensor.max_range_m = 6.0;
  sensor.baseline_m = 0.05;
  sensor.left_eye_m = 0.05;
  sensor.disparity_focal_px = 385;
  sensor.disparity_step_px = 1.0 / 32;
  sensor.axial_quadratic_per_m = 0.08 / (sensor.disparity_focal_px * sensor.baseline_m);
  sensor.lateral_px = 0.7;
  sensor.noise_reach_px = 4;
  sensor.bias_quadratic_per_m = 0.002;
  sensor.mixed_share = 0.5;
  sensor.signal_lost = 0.0002;
  sensor.signal_sure = 0.0008;
  return sensor;
}

DepthSensor PhoneLidar() {
  DepthSensor sensor;
  sensor.name = "phone_lidar";
  sensor.camera = {640, 480, 483.0, 483.0, 319.5, 239.5};
  sensor.min_range_m = 0.2;
  sensor.max_range_m = 5.0;
  sensor.axial_constant_m = 0.005;
  sensor.axial_linear = 0.002;
  sensor.bias_constant_m = 0.005;
  sensor.mixed_share = 0.5;
  sensor.signal_lost = 0.001;
  sensor.signal_sure = 0.003;
  sensor.cell_px = 5;
  return sensor;
}

}  // namespace

std::optional<DepthSensor> DepthSensorPreset(std::string_view name) {
  for (DepthSensor sensor : {KinectV1(), KinectV2(), D435(), PhoneLidar()}) {
    if (sensor.name == name) return sensor;
  }
  return std::nullopt;
}

std::vector<std::string> DepthSensorPresetNames() {
  return {"kinect_v1", "kinect_v2", "d435", "phone_lidar"};
}

namespace {

// z^power; the models' powers are halves, and this is asked for every pixel.
double Power(double z, double power) {
  if (power == -0.5) return 1 / std::sqrt(z);
  if (power == 1.5) return z * std::sqrt(z);
  return std::pow(z, power);
}

}  // namespace

double AxialDeviation(const DepthSensor& sensor, double depth_m, double theta_rad) {
  const double beyond_m = depth_m - sensor.axial_around_m;
  double deviation_m = sensor.axial_constant_m + sensor.axial_linear * depth_m +
                       sensor.axial_quadratic_per_m * beyond_m * beyond_m;
  if (sensor.axial_angle_m > 0) {
    const double theta = std::clamp(theta_rad, 0.0, kMaxTheta);
    const double ratio = theta / (std::numbers::pi / 2 - theta);
    deviation_m += sensor.axial_angle_m * Power(depth_m, sensor.axial_angle_power) * ratio * ratio;
  }
  return std::max(0.0, deviation_m);
}

double LateralDeviation(const DepthSensor& sensor, double theta_rad) {
  const double theta = std::clamp(theta_rad, 0.0, kMaxTheta);
  return sensor.lateral_px + sensor.lateral_angle_px * theta / (std::numbers::pi / 2 - theta);
}

double InfraredReflectance(double visible) {
  // So that black at 1 to 3 m has depth (the figures in the header).
  constexpr double kOfBlack = 0.03;
  return kOfBlack + (1 - kOfBlack) * visible;
}

double RangeBias(const DepthSensor& sensor, double depth_m) {
  return sensor.bias_constant_m + sensor.bias_quadratic_per_m * depth_m * depth_m;
}

double QuantisedDepth(const DepthSensor& sensor, double depth_m) {
  if (!(sensor.disparity_step_px > 0) || !(sensor.baseline_m > 0)) return depth_m;
  const double focal_baseline = sensor.disparity_focal_px * sensor.baseline_m;
  // To the nearest; std::round is a call on machines of the baseline instruction set.
  const double steps = focal_baseline / (depth_m * sensor.disparity_step_px);
  const auto whole = static_cast<std::int64_t>(std::min(steps, 1e9) + 0.5);
  return whole > 0 ? focal_baseline / (static_cast<double>(whole) * sensor.disparity_step_px) : 0.0;
}

}  // namespace deepslam::synth
