#include "deepslam/synth/scene_description.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "deepslam/synth/scene_table.h"

namespace deepslam::synth {
namespace {

constexpr int kMaxSceneFrames = 100'000;    // more are refused, as a slip would fill the disk
constexpr double kLeastFrames_per_s = 0.1;  // one in ten seconds shows no way
constexpr double kMostFrames_per_s = 1000;  // no depth camera is as fast
constexpr int kMaxRenderedSidePx = 4096;    // larger pictures are refused for their memory
constexpr int kMaxRungDepth = 8;            // tables in tables; more hold themselves

// A smaller picture of the same sensor: what the sensor does over so many of its pixels it does
// over as much of the picture.
DepthSensor SeenByWidth(DepthSensor sensor, int width) {
  const double ratio = static_cast<double>(width) / sensor.camera.width;
  sensor.lateral_px *= ratio;
  sensor.lateral_angle_px *= ratio;
  sensor.noise_reach_px *= ratio;
  sensor.cell_px = std::max(1, static_cast<int>(std::lround(sensor.cell_px * ratio)));
  return sensor;
}

void ReadCamera(SceneTable camera, SceneDescription& scene) {
  std::string preset = scene.sensor.name;
  camera.Text("preset", preset, false);
  PinholeCamera& value = scene.camera;
  if (const std::optional<DepthSensor> sensor = DepthSensorPreset(preset)) {
    if (preset != scene.sensor.name) value = sensor->camera;
    scene.sensor = *sensor;
  } else {
    const std::vector<std::string> known = DepthSensorPresetNames();
    camera.Fail(camera.At("preset"),
                camera.Path("preset"),
                fmt::format("is '{}'{}, expected one of {}",
                            preset,
                            NearestOf(preset, known),
                            fmt::join(known, ", ")));
  }
  camera.Number("width", value.width, 16, kMaxRenderedSidePx);
  camera.Number("height", value.height, 16, kMaxRenderedSidePx);
  camera.Number("fx", value.fx, 0.05 * value.width, 50.0 * value.width);
  camera.Number("fy", value.fy, 0.05 * value.height, 50.0 * value.height);
  camera.Number("cx", value.cx, 0, value.width - 1);
  camera.Number("cy", value.cy, 0, value.height - 1);
  camera.Number("roll_deg", scene.roll_deg, -180, 180);
  camera.RefuseOthers();
  scene.sensor = SeenByWidth(scene.sensor, value.width);
}

void ReadRoom(SceneTable room, SceneDescription& scene) {
  room.Vec("size_m", scene.room_size_m, 1, 100);
  room.Text("floor", scene.floor, false);
  if (scene.floor != "wood" && scene.floor != "carpet" && scene.floor != "tiles") {
    room.Fail(room.At("floor"),
              room.Path("floor"),
              fmt::format("is '{}', expected wood, carpet or tiles", scene.floor));
  }
  Eigen::Vector3d wall(scene.wall_colour.r, scene.wall_colour.g, scene.wall_colour.b);
  room.Vec("wall_colour_rgb", wall, 0, 255);
  scene.wall_colour = {static_cast<std::uint8_t>(wall.x()),
                       static_cast<std::uint8_t>(wall.y()),
                       static_cast<std::uint8_t>(wall.z())};
  room.Number("posters", scene.num_posters, 0, 40);
  room.Number("ambient", scene.ambient, 0, 1);
  room.RefuseOthers();
}

void ReadOrbit(SceneTable orbit, SceneOrbit& value) {
  orbit.Vec("centre_m", value.centre_m, -100, 100);
  orbit.Number("radius_m", value.radius_m, 0.1, 100);
  orbit.Number("height_m", value.height_m, 0.1, 100);
  orbit.Number("target_height_m", value.target_height_m, 0, 100);
  orbit.Number("start_deg", value.start_deg, -3600, 3600);
  orbit.Number("sweep_deg", value.sweep_deg, -3600, 3600);
  orbit.Number("shake_m", value.shake_m, 0, 1);
  orbit.Number("shake_deg", value.shake_deg, 0, 30);
  orbit.RefuseOthers();
}

void ReadWalk(SceneTable walk, SceneWalk& value) {
  walk.Points("points_m", value.points_m);
  walk.Points("look_at_m", value.look_at_m);
  walk.Number("ahead_height_m", value.ahead_height_m, 0, 100);
  walk.Switch("closed", value.closed);
  walk.Switch("and_back", value.and_back);
  walk.Number("laps", value.laps, 0.01, 100);
  walk.Number("turn_m_per_rad", value.turn_m_per_rad, 0, 10);
  walk.Number("shake_m", value.shake_m, 0, 1);
  walk.Number("shake_deg", value.shake_deg, 0, 30);
  walk.Number("step_m", value.step_m, 0, 1);
  walk.RefuseOthers();
  const auto fail = [&](const char* field, const std::string& what) {
    walk.Fail(walk.At(field), walk.Path(field), what);
  };
  if (value.points_m.size() == 1) fail("points_m", "holds one point, expected two or more");
  if (value.look_at_m.size() > 1 && value.look_at_m.size() != value.points_m.size())
    fail("look_at_m", "must hold one point, or as many as points_m");
}

void ReadFaults(SceneTable faults, SensorFaults& value) {
  bool all = true;
  bool noise = true;
  bool holes = true;
  faults.Switch("all", all);
  faults.Switch("depth_noise", noise);
  faults.Switch("depth_holes", holes);
  if (!all) value = SensorFaults::None();
  if (!noise)
    value.axial_noise = value.lateral_noise = value.quantisation = value.mixed_pixels = false;
  if (!holes) {
    value.range_limits = value.grazing_holes = value.dark_holes = value.shiny_holes = false;
    value.shadows = value.rim = false;
  }
  faults.Switch("axial_noise", value.axial_noise);
  faults.Switch("lateral_noise", value.lateral_noise);
  faults.Switch("quantisation", value.quantisation);
  faults.Switch("mixed_pixels", value.mixed_pixels);
  faults.Switch("range_limits", value.range_limits);
  faults.Switch("grazing_holes", value.grazing_holes);
  faults.Switch("dark_holes", value.dark_holes);
  faults.Switch("shiny_holes", value.shiny_holes);
  faults.Switch("rim", value.rim);
  faults.Switch("shadows", value.shadows);
  faults.Switch("range_bias", value.range_bias);
  faults.Number("noise_scale", value.noise_scale, 0, 100);
  faults.Number("missing_share", value.missing_share, 0, 1);
  faults.Number("table_edges_m", value.table_edges_m, 0, 10);
  faults.Switch("colour_noise", value.colour_noise);
  faults.Number("exposure_time_s", value.exposure_time_s, 0, 1);
  faults.Number("exposure_change_stops", value.exposure_change_stops, 0, 4);
  faults.Number("dropped_share", value.dropped_share, 0, 0.9);
  faults.RefuseOthers();
}

void ReadObject(SceneTable object, SceneDescription& scene) {
  SceneObject value;
  object.Text("class", value.class_name, true);
  object.Text("model", value.model, true);
  object.Vec("position_m", value.position_m, -100, 100, true);
  object.Number("yaw_deg", value.yaw_deg, -3600, 3600);
  object.Number("bottom_m", value.bottom_m, 0, 100);
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  object.Vec("size_m", size_m, 0.01, 20);
  if (size_m.x() > 0) value.size_m = size_m;
  object.RefuseOthers();
  value.line = object.line();
  scene.objects.push_back(value);
}

void ReadGap(SceneTable opening, SceneOpening& value) {
  opening.Number("from_m", value.from_m, 0, 100);
  opening.Number("width_m", value.width_m, 0.05, 100);
  opening.Number("bottom_m", value.bottom_m, 0, 100);
  opening.Number("height_m", value.height_m, 0.05, 100);
  opening.Switch("closed", value.closed);
  opening.RefuseOthers();
  value.line = opening.line();
}

void ReadOpening(SceneTable opening, SceneDescription& scene) {
  static constexpr std::array<const char*, 4> kWalls = {"east", "north", "west", "south"};
  SceneOpening value;
  std::string wall;
  opening.Text("wall", wall, true);
  const auto found = std::find(kWalls.begin(), kWalls.end(), wall);
  if (found == kWalls.end() && !wall.empty()) {
    opening.Fail(opening.At("wall"),
                 opening.Path("wall"),
                 fmt::format("is '{}', expected {}", wall, fmt::join(kWalls, ", ")));
  }
  value.wall = static_cast<int>(found - kWalls.begin()) % 4;
  ReadGap(opening, value);
  scene.openings.push_back(value);
}

void ReadPartition(SceneTable partition, SceneDescription& scene) {
  ScenePartition value;
  partition.Vec("from_m", value.from_m, -100, 100, true);
  partition.Vec("to_m", value.to_m, -100, 100, true);
  partition.Number("thickness_m", value.thickness_m, 0.01, 1);
  for (const SceneTable& gap : partition.List("openings")) {
    value.openings.emplace_back();
    ReadGap(gap, value.openings.back());
  }
  partition.RefuseOthers();
  value.line = partition.line();
  const Eigen::Vector2d along = value.to_m - value.from_m;
  if (std::min(std::abs(along.x()), std::abs(along.y())) > 1e-9 || along.norm() < 0.1)
    partition.Fail(partition.At("to_m"),
                   partition.Path("to_m"),
                   "must lie 10 cm or more from from_m, along x or along y");
  scene.partitions.push_back(value);
}

void ReadLists(SceneTable& root, SceneDescription& scene) {
  for (SceneTable light : root.List("lights")) {
    SceneLight value;
    light.Vec("position_m", value.position_m, -100, 100, true);
    light.Number("side_m", value.side_m, 0.01, 10);
    light.Number("power", value.power, 0, 1000);
    light.RefuseOthers();
    scene.lights.push_back(value);
  }
  for (SceneTable object : root.List("objects")) ReadObject(object, scene);
  for (SceneTable opening : root.List("openings")) ReadOpening(opening, scene);
  for (SceneTable partition : root.List("partitions")) ReadPartition(partition, scene);
  SceneTable clutter = root.Sub("clutter");
  clutter.Number("floor_boxes", scene.clutter.num_floor_boxes, 0, 100);
  clutter.Number("per_table", scene.clutter.num_per_table, 0, 50);
  clutter.RefuseOthers();
}

// How the scene is filmed, whatever stands in it.
void ReadFilming(SceneTable& root, SceneDescription& scene) {
  root.Number("frames", scene.num_frames, 1, kMaxSceneFrames);
  root.Number("frames_per_s", scene.frames_per_s, kLeastFrames_per_s, kMostFrames_per_s);
  root.Number("depth_units_per_m", scene.depth_units_per_m, 1, 10'000);
  ReadCamera(root.Sub("camera"), scene);
  ReadOrbit(root.Sub("orbit"), scene.orbit);
  ReadWalk(root.Sub("walk"), scene.walk);
  ReadFaults(root.Sub("faults"), scene.faults);
}

SceneDescription ReadScene(SceneTable root) {
  SceneDescription scene;
  scene.camera = scene.sensor.camera;
  int seed = 1;
  root.Number("seed", seed, 0, 2'000'000'000);
  scene.seed = static_cast<std::uint64_t>(seed);
  ReadFilming(root, scene);
  ReadRoom(root.Sub("room"), scene);
  ReadLists(root, scene);
  (void)root.Sub("rungs");
  root.RefuseOthers();
  return scene;
}

// NAME=VALUE as a table of tables; the name's parts are their fields.
YAML::Node TableOf(const std::string& setting, std::size_t equals) {
  YAML::Node node = YAML::Load(setting.substr(equals + 1));
  std::size_t end = equals;
  while (end != std::string::npos) {
    const std::size_t dot = end == 0 ? std::string::npos : setting.rfind('.', end - 1);
    const std::size_t begin = dot == std::string::npos ? 0 : dot + 1;
    YAML::Node table;
    table[setting.substr(begin, end - begin)] = node;
    node.reset(table);
    end = dot;
  }
  return node;
}

// Fields of `over` replace those of `base`, tables field by field. In place, since copies of nodes
// forget their lines. Anchors can make tables that hold themselves: no scene is as deep as those.
void Overlay(YAML::Node base, const YAML::Node& over, int depth) {
  if (base.is(over)) return;
  if (depth > kMaxRungDepth)
    throw YAML::RepresentationException(over.Mark(), "a rung's tables are nested too deeply");
  // Listed first: a rung that holds rungs may replace the very table that is gone through.
  std::vector<std::pair<std::string, YAML::Node>> fields;
  for (const auto& entry : over) fields.emplace_back(entry.first.Scalar(), entry.second);
  for (const auto& [name, field] : fields) {
    const YAML::Node old = std::as_const(base)[name];
    if (old.IsDefined() && old.IsMap() && field.IsMap()) {
      Overlay(old, field, depth + 1);
    } else {
      base[name] = field;
    }
  }
}

Status ChooseRung(YAML::Node root, const std::filesystem::path& file, const std::string& rung) {
  if (rung.empty()) return Ok();
  const YAML::Node rungs = std::as_const(root)["rungs"];
  const bool has_rungs = rungs.IsDefined() && rungs.IsMap();
  if (has_rungs) {
    const YAML::Node over = rungs[rung];
    if (over.IsDefined() && over.IsMap()) Overlay(root, over, 0);
    if (over.IsDefined() && (over.IsMap() || over.IsNull())) return Ok();
  }
  std::vector<std::string> known;
  if (has_rungs) {
    for (const auto& entry : rungs) known.push_back(entry.first.Scalar());
  }
  return InvalidConfig(
      fmt::format("{}: has no rung '{}'{}; its rungs: {}",
                  file.string(),
                  rung,
                  NearestOf(rung, known),
                  known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
}

}  // namespace

Result<SceneDescription> AtFrameRate(SceneDescription scene, double frames_per_s) {
  if (!(frames_per_s >= kLeastFrames_per_s && frames_per_s <= kMostFrames_per_s)) {
    return InvalidConfig(fmt::format("{} frames a second: must be from {} to {}",
                                     frames_per_s,
                                     kLeastFrames_per_s,
                                     kMostFrames_per_s));
  }
  const double num_frames = std::round(scene.num_frames / scene.frames_per_s * frames_per_s);
  if (num_frames > kMaxSceneFrames) {
    return InvalidConfig(
        fmt::format("{} frames a second make {} frames, more than {}; choose a "
                    "slower rate",
                    frames_per_s,
                    num_frames,
                    kMaxSceneFrames));
  }
  scene.num_frames = std::max(1, static_cast<int>(num_frames));
  scene.frames_per_s = frames_per_s;
  return scene;
}

Result<SceneDescription> FilmedWith(SceneDescription scene, const std::string& setting) {
  const std::string option = "--field " + setting;
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    return InvalidConfig(option + ": expected NAME=VALUE, as in camera.preset=d435");
  try {
    std::optional<Error> fault;
    SceneTable root(TableOf(setting, equals), {}, "", fault);
    ReadFilming(root, scene);
    root.RefuseOthers();
    if (fault) return InvalidConfig(option + ": " + fault->message);
    return scene;
  } catch (const YAML::Exception& fault) {
    return InvalidConfig(fmt::format("{}: not valid YAML ({})", option, fault.msg));
  }
}

SensorFaults SensorFaults::None() {
  SensorFaults none;
  none.axial_noise = none.lateral_noise = none.quantisation = none.mixed_pixels = false;
  none.range_limits = none.grazing_holes = none.dark_holes = none.shiny_holes = false;
  none.rim = none.shadows = none.range_bias = none.colour_noise = false;
  none.exposure_time_s = 0;
  return none;
}

Result<SceneDescription> ParseScene(const std::string& text,
                                    const std::filesystem::path& file,
                                    const std::string& rung) {
  try {
    std::optional<Error> fault;
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap())
      return InvalidConfig(
          fmt::format("{}: holds no scene; see configs/scenes/demo_room.yaml", file.string()));
    const Status chosen = ChooseRung(root, file, rung);
    if (!chosen) return chosen.error();
    SceneDescription scene = ReadScene(SceneTable(root, file, "", fault));
    if (fault) return *fault;
    return scene;
  } catch (const YAML::Exception& fault) {
    return InvalidConfig(fmt::format("{}:{}: not valid YAML ({})",
                                     file.string(),
                                     fault.mark.is_null() ? 1 : fault.mark.line + 1,
                                     fault.msg));
  }
}

}  // namespace deepslam::synth
