// A scene with its models in place: what is rendered, and the truth about it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/synth/furniture_model.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

struct PlacedObject {
  std::string class_name;
  std::string model;  // catalogue id
  TriangleMesh mesh;  // object frame, metres
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Pose3 world_from_object;          // stands on the floor
  std::vector<std::uint8_t> shiny;  // per face: polished or transparent; or empty
  bool has_support_plane = false;   // things stand on it
};

enum class RoomSurface { kFloor, kWall, kCeiling, kPoster };

struct RoomPart {
  RoomSurface surface = RoomSurface::kWall;
  int number = 0;     // poster or wall number: seeds its pattern
  TriangleMesh mesh;  // world, metres
  // Axes of the pattern: world point -> (u, v) metres on the part.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d u_axis = Eigen::Vector3d::UnitX();
  Eigen::Vector3d v_axis = Eigen::Vector3d::UnitY();
  Eigen::Vector2d extent_m = Eigen::Vector2d::Ones();
};

struct World {
  SceneDescription description;
  std::vector<PlacedObject> objects;
  std::vector<RoomPart> room;
  std::vector<TriangleMesh> clutter;  // world, coloured; no objects of the truth
  std::vector<std::string> warnings;
};

// Places the models, by catalogue id or file name, and builds the room. Errors name the object: a
// model that is not there, an object outside the room, an opening beyond its wall, a camera path
// that enters an object's box. A path that leads through a wall is a warning. `classes` says on
// what things may stand.
Result<World> BuildWorld(const SceneDescription& description,
                         const std::map<std::string, FurnitureModel>& models,
                         const ClassTable& classes);

// Floor, walls, ceiling and posters as one mesh, world.
TriangleMesh RoomMesh(const World& world);

}  // namespace deepslam::synth
