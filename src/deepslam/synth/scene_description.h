// A room to be rendered, as a scene file (configs/scenes/*.yaml) describes it.
//
// World frame: z up, floor z = 0, origin at the middle of the floor; walls at x = +-size_x / 2, y =
// +-size_y / 2.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/synth/depth_sensor.h"

namespace deepslam::synth {

struct SceneObject {
  std::string class_name;  // of the class table
  std::string model;       // catalogue id ("Scopia#chair"), or a file (.obj, .gltf, .glb)
  Eigen::Vector2d position_m =
      Eigen::Vector2d::Zero();  // of the middle of the model's box, on the floor
  double yaw_deg = 0;           // the model's front turned from world x towards y
  int line = 0;                 // of the scene file, for messages
  // Along x (front), y, z: scales the model; without it, its own size (files: y up, metres).
  std::optional<Eigen::Vector3d> size_m;
  double bottom_m = 0;  // above the floor: of what stands on furniture or hangs on a wall
};

struct SceneOpening {  // a door or window: a gap in a wall
  int wall = 0;        // 0 east (+x), 1 north (+y), 2 west, 3 south
  double from_m = 1;   // its left edge seen from inside, from the wall's left end
  double width_m = 0.9;
  double bottom_m = 0;
  double height_m = 2.05;
  int line = 0;
  bool closed = false;  // a leaf fills it: nobody sees what is behind
};

// A wall within the room, from floor to ceiling along x or y: it makes rooms of it. Gaps count from
// `from_m` on; their `wall` says nothing.
struct ScenePartition {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();  // middle of its thickness
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double thickness_m = 0.1;
  std::vector<SceneOpening> openings;
  int line = 0;
};

struct SceneClutter {  // small things, no objects of the truth: they get in the way
  int num_floor_boxes = 0;
  int num_per_table = 0;  // boxes, books and cups on each object of class table
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

// A way through points at even speed, on a smooth curve (Catmull-Rom).
struct SceneWalk {
  std::vector<Eigen::Vector3d> points_m;  // none: the orbit is the way
  // What the camera looks at, by point; one: always that; none: 1.5 m ahead on the way, at
  // `ahead_height_m`.
  std::vector<Eigen::Vector3d> look_at_m;
  double ahead_height_m = 0.6;
  bool closed = false;    // on from the last point to the first
  bool and_back = false;  // the same way back, looking as on the way there
  double laps = 1;        // of a closed way; 1.2 sees its beginning again
  // How far one walks in the time in which the view turns by a radian, m: where it turns faster,
  // one waits. 0: turns take no time.
  double turn_m_per_rad = 0;
  double shake_m = 0.015;
  double shake_deg = 0.8;
  double step_m = 0.012;  // up and down with each step, standard deviation
};

// Every fault of the sensor (depth_sensor.h) can be switched; what has no switch has a size.
struct SensorFaults {
  bool axial_noise = true;
  bool lateral_noise = true;
  bool quantisation = true;
  bool mixed_pixels = true;
  bool range_limits = true;
  bool grazing_holes = true;
  bool dark_holes = true;
  bool shiny_holes = true;
  bool rim = true;      // no depth at the border of the picture
  bool shadows = true;  // of the projector (or where the second eye sees nothing)
  bool range_bias = false;
  double noise_scale = 1;    // times axial and lateral deviation
  double missing_share = 0;  // of all pixels, in patches
  double table_edges_m = 0;  // table tops return depth this near their edges only; 0: everywhere
  bool colour_noise = true;  // photon noise, the lens's blur and vignetting
  double exposure_time_s = 0.008;    // motion blur; 0: none
  double exposure_change_stops = 0;  // standard deviation of the slow drift of intensity
  double dropped_share = 0;          // of frames

  static SensorFaults None();
};

struct SceneDescription {
  std::uint64_t seed = 1;
  int num_frames = 120;
  double frames_per_s = 30;
  PinholeCamera camera;
  double roll_deg =
      0;  // how it is held: clockwise, seen from behind; 90 lays pictures on their side
  DepthSensor sensor = *DepthSensorPreset("kinect_v1");  // its pixels brought to the camera's
  double depth_units_per_m = 1000;
  Eigen::Vector3d room_size_m = {5, 5, 2.6};
  std::string floor = "wood";  // wood, carpet, tiles
  Rgb8 wall_colour = {222, 216, 204};
  int num_posters = 5;
  double ambient = 0.35;  // light from everywhere, share of white
  std::vector<SceneLight> lights;
  std::vector<SceneObject> objects;
  std::vector<SceneOpening> openings;
  std::vector<ScenePartition> partitions;
  SceneClutter clutter;
  SceneOrbit orbit;
  SceneWalk walk;
  SensorFaults faults;
};

// The same way in the same time, at another number of frames a second; an error where that is not a
// rate or gives more frames than a scene may have.
Result<SceneDescription> AtFrameRate(SceneDescription scene, double frames_per_s);

// The scene with one field of how it is filmed replaced: `camera.preset=d435`,
// `faults.noise_scale=4`, fields of camera, faults, orbit and walk and the numbers beside them, as
// scene files name them. What stands in the scene stays. Errors name the field and what is
// expected.
Result<SceneDescription> FilmedWith(SceneDescription scene, const std::string& setting);

// Reads the text of a scene file; errors name file, line, field and what is expected. Unknown
// fields are errors. A scene may hold `rungs: {NAME: {...}}`, variants of itself: the fields of the
// rung named `rung` replace the scene's (tables field by field, lists whole). Empty: the scene as
// it stands.
Result<SceneDescription> ParseScene(const std::string& text,
                                    const std::filesystem::path& file,
                                    const std::string& rung = "");

}  // namespace deepslam::synth
