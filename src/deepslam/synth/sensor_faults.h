// What a structured-light depth camera and a cheap colour camera do to the truth.
#pragma once

#include "deepslam/core/image.h"
#include "deepslam/core/random.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/render/render_view.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// Kinect v1. Baseline between projector and camera, and steps of its disparity (Khoshelham,
// Elberink 2012).
inline constexpr double kBaselineM = 0.075;
inline constexpr double kDisparityStepPx = 0.125;
inline constexpr double kMinRangeM = 0.45;
inline constexpr double kMaxRangeM = 6.0;

// Standard deviation of depth along the axis (Nguyen, Izadi, Lovell 2012, Eq. 3 without the term of
// steep views, which become holes), metres.
double AxialNoise(double depth_m);

// Depth as the sensor gives it; 0 = hole. `random_item` is the frame's number.
DepthImage ApplyDepthFaults(const render::RenderedView& truth,
                            const PinholeCamera& camera,
                            const Pose3& world_from_camera,
                            const SensorFaults& faults,
                            std::uint64_t seed,
                            std::uint64_t random_item);

// Sensor noise and the lens's slight blur and vignetting, in place of a clean picture. Linear
// colours in [0, 1] in, display colours out.
ColourImage DevelopColour(const Image<Eigen::Vector3f>& radiance,
                          const SensorFaults& faults,
                          std::uint64_t seed,
                          std::uint64_t random_item);

}  // namespace deepslam::synth
