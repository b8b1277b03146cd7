// What a depth camera and a cheap colour camera do to the truth.
//
// The models: deviation, bias and steps of the depth by the sensor (depth_sensor.h). Beside them,
// as Khoshelham, Elberink 2012 and Nguyen, Izadi, Lovell 2012 describe for structured light and
// Wasenmueller, Stricker 2016 for time of flight: no depth on faces seen at a grazing angle, on
// surfaces that return too little light, on polished ones that throw it elsewhere, and where the
// projector (or second eye) does not see; values between two surfaces at edges. Sensors that match
// windows share noise and loss between neighbours (DepthSensor::noise_reach_px).
#pragma once

#include "deepslam/core/image.h"
#include "deepslam/core/random.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/render/render_view.h"
#include "deepslam/synth/depth_sensor.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// What is before the sensor, per pixel; empty images: bright, dull, nothing blind.
struct SensedView {
  render::RenderedView view;
  Image<float> reflectance;  // [0, 1]
  Mask shiny;                // polished or transparent
  Mask blind;                // gives no depth, whatever the sensor
};

// Numbers of the noise of one frame.
struct FrameSeed {
  std::uint64_t seed = 0;
  std::uint64_t frame = 0;
};

// Depth as the sensor gives it; 0 = hole. Same result for any number of threads.
DepthImage ApplyDepthFaults(const SensedView& truth,
                            const PinholeCamera& camera,
                            const Pose3& world_from_camera,
                            const SceneDescription& scene,
                            const FrameSeed& seed);

// Sensor noise and the lens's slight blur and vignetting, in place of a clean picture; `gain` is
// the exposure. Linear colours in [0, 1] in, display colours out.
ColourImage DevelopColour(const Image<Eigen::Vector3f>& radiance,
                          const SensorFaults& faults,
                          double gain,
                          const FrameSeed& seed);

// The picture smeared along each pixel's way while the shutter is open: from its place seen by the
// first camera to that seen by the last.
Image<Eigen::Vector3f> MotionBlurred(const Image<Eigen::Vector3f>& radiance,
                                     const DepthImage& depth_m,
                                     const PinholeCamera& camera,
                                     const Pose3& first_from_camera,
                                     const Pose3& last_from_camera);

}  // namespace deepslam::synth
