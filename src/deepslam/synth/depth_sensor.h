// What a depth camera is like: its lens, its range, and the size of its errors by published models.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/geometry/camera.h"

namespace deepslam::synth {

// Depth z in metres along the axis, theta the angle between a surface's normal and the ray towards
// the camera. The models' constants are those of the papers named at each preset.
struct DepthSensor {
  std::string name;
  PinholeCamera camera;  // of the depth as captures hold it: registered to the colour camera
  double min_range_m = 0;
  double max_range_m = 0;

  // Standard deviation along the axis: constant + linear z + quadratic (z - around)^2
  //   + angle z^angle_power theta^2 / (pi/2 - theta)^2.
  double axial_constant_m = 0;
  double axial_linear = 0;
  double axial_quadratic_per_m = 0;
  double axial_around_m = 0;
  double axial_angle_m = 0;
  double axial_angle_power = 0;
  // Standard deviation of the place in the image that a value really comes from: constant + angle
  // theta / (pi/2 - theta).
  double lateral_px = 0;
  double lateral_angle_px = 0;
  // Neighbours share noise: its correlation falls as exp(-distance / reach) along rows and columns.
  // 0: every pixel has its own.
  double noise_reach_px = 0;

  // Sensors that triangulate: distance between the two eyes (0: time of flight), and how finely
  // they measure disparity in a picture of this focal length.
  double baseline_m = 0;
  double disparity_focal_px = 0;
  double disparity_step_px = 0;  // 0: not quantised
  // Distance from the colour camera to the eye or projector left of it, and to that right of it:
  // what a near edge hides from the one has no depth right of the edge, from the other left of it.
  double left_eye_m = 0;
  double right_eye_m = 0;

  // Mean error: constant + quadratic z^2.
  double bias_constant_m = 0;
  double bias_quadratic_per_m = 0;

  // Share of the pixels at an edge that lie between the two surfaces.
  double mixed_share = 0;
  // Returned light, infrared reflectance x cos theta / z^2: below `lost` no depth, above `sure`
  // always.
  double signal_lost = 0;
  double signal_sure = 0;
  // Border of the picture without depth, where the depth camera registered to the colour camera
  // does not see: left, right, top, bottom, as shares of width and height.
  std::array<double, 4> rim = {0, 0, 0, 0};
  // Measured cells are this many pixels wide, and what lies between is interpolated. 1: every
  // pixel.
  int cell_px = 1;
};

// kinect_v1, kinect_v2, d435, phone_lidar:
//  - kinect_v1: disparity in steps of 1/8 px over 7.5 cm (Khoshelham, Elberink 2012); axial noise
//    1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2 + 0.1 mm z^-1/2 theta^2 / (pi/2 - theta)^2, lateral
//    0.8 px + 0.035 px theta / (pi/2 - theta) (Nguyen, Izadi, Lovell 2012, Eq. 1-3). Neighbours
//    share it, since values come from windows of 9 x 9 px (Konolige, Mihelich 2012): on walls and
//    tables of TUM RGB-D and 7-Scenes the correlation is 0.6-0.8 at 1 px, 0.4 at 4 px, 0.1 at 8 px.
//    Rim and shadows on both sides are those of depth registered to the colour camera, which
//    stands between projector and infrared camera.
//  - kinect_v2: time of flight; 1.5 mm - 0.5 mm/m z + 0.3 mm/m^2 z^2
//    + 0.1 mm z^3/2 theta^2 / (pi/2 - theta)^2 (Fankhauser et al. 2015); mixed pixels and loss on
//    dark surfaces as Wasenmueller, Stricker 2016 describe.
//  - d435: stereo; deviation z^2 0.08 px / (f b) with b = 5 cm (Intel's tuning guide, Keselman et
//    al. 2017), disparity in steps of 1/32 px, shared over the matching window as for kinect_v1.
//  - phone_lidar: few points, filled in: cells of 5 px stand for the interpolation; about 1 cm at
//    arm's length to room size, range 5 m (Luetzenburg, Kroon, Bjork 2021).
std::optional<DepthSensor> DepthSensorPreset(std::string_view name);
std::vector<std::string> DepthSensorPresetNames();

// By the sensor's formula; theta in [0, pi/2).
double AxialDeviation(const DepthSensor& sensor, double depth_m, double theta_rad);
double LateralDeviation(const DepthSensor& sensor, double theta_rad);
// What a surface sends back of near infrared, from its visible reflectance. Most dyes are transparent
// there, and what looks black is not: pixels of grey value 10 to 30 have depth in 0.8 of all cases
// in 7-Scenes redkitchen and in 0.99 in TUM fr3_cabinet, at 1 to 3 m.
double InfraredReflectance(double visible);
double RangeBias(const DepthSensor& sensor, double depth_m);
// Nearest depth that the sensor's disparity steps can express; 0 when there is none.
double QuantisedDepth(const DepthSensor& sensor, double depth_m);

}  // namespace deepslam::synth
