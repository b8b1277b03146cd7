// A room to be rendered, as a scene file (configs/scenes/*.yaml) describes it.
//
// World frame: z up, floor z = 0, origin at the middle of the floor; walls at x = +-size_x / 2, y =
// +-size_y / 2.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::synth {

struct SceneObject {
  std::string class_name;  // of the class table
  std::string model;       // catalogue id ("Scopia#chair")
  Eigen::Vector2d position_m =
      Eigen::Vector2d::Zero();  // of the middle of the model's box, on the floor
  double yaw_deg = 0;           // the model's front turned from world x towards y
  int line = 0;                 // of the scene file, for messages
};

struct SceneLight {  // a horizontal square that shines downwards
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double side_m = 0.6;
  double power = 1.0;  // of a white surface 1 m below
};

struct SceneOrbit {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 2.2;
  double height_m = 1.6;
  double target_height_m = 0.5;  // the camera looks at this height above the centre
  double start_deg = 0;
  double sweep_deg = 150;
  // Hand: slow sway of the camera's place and of the direction it looks, standard deviations.
  double shake_m = 0.015;
  double shake_deg = 0.8;
};

struct SensorFaults {
  bool depth_noise = true;  // axial and lateral noise, disparity steps
  bool depth_holes = true;  // grazing views, shadow of the projector, range
  bool colour_noise = true;
};

struct SceneDescription {
  std::uint64_t seed = 1;
  int num_frames = 120;
  double frames_per_s = 30;
  PinholeCamera camera;
  double depth_units_per_m = 1000;
  Eigen::Vector3d room_size_m = {5, 5, 2.6};
  std::string floor = "wood";  // wood, carpet, tiles
  Rgb8 wall_colour = {222, 216, 204};
  int num_posters = 5;
  double ambient = 0.35;  // light from everywhere, share of white
  std::vector<SceneLight> lights;
  std::vector<SceneObject> objects;
  SceneOrbit orbit;
  SensorFaults faults;
};

// Reads the text of a scene file; errors name file, line, field and what is expected. Unknown
// fields are errors.
Result<SceneDescription> ParseScene(const std::string& text, const std::filesystem::path& file);

}  // namespace deepslam::synth
