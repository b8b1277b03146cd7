#include "deepslam/synth/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/random.h"
#include "deepslam/synth/camera_path.h"

namespace deepslam::synth {
namespace {

constexpr double kCameraMarginM = 0.1;
constexpr double kPosterGapM = 0.004;  // before its wall

RoomPart Rectangle(RoomSurface surface,
                   int number,
                   const Eigen::Vector3d& origin,
                   const Eigen::Vector3d& u_axis,
                   const Eigen::Vector3d& v_axis,
                   const Eigen::Vector2d& extent_m) {
  RoomPart part{surface, number, TriangleMesh(), origin, u_axis, v_axis, extent_m};
  const Eigen::Vector3d u = u_axis * extent_m.x();
  const Eigen::Vector3d v = v_axis * extent_m.y();
  for (const Eigen::Vector3d& p : {origin,
                                   Eigen::Vector3d(origin + u),
                                   Eigen::Vector3d(origin + u + v),
                                   Eigen::Vector3d(origin + v)}) {
    part.mesh.vertices.push_back(p.cast<float>());
  }
  part.mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return part;
}

// Faces look into the room: u x v is the inward normal of every part.
std::vector<RoomPart> MakeRoom(const SceneDescription& description) {
  const Eigen::Vector3d s = description.room_size_m;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  std::vector<RoomPart> room;
  room.push_back(
      Rectangle(RoomSurface::kFloor, 0, {-s.x() / 2, -s.y() / 2, 0}, x, y, {s.x(), s.y()}));
  room.push_back(
      Rectangle(RoomSurface::kCeiling, 0, {-s.x() / 2, s.y() / 2, s.z()}, x, -y, {s.x(), s.y()}));
  struct Wall {
    Eigen::Vector3d origin, along;
    double length_m;
  };
  // Seen from inside, `along` runs to the right.
  const std::vector<Wall> walls = {{{s.x() / 2, s.y() / 2, 0}, -y, s.y()},
                                   {{-s.x() / 2, s.y() / 2, 0}, x, s.x()},
                                   {{-s.x() / 2, -s.y() / 2, 0}, y, s.y()},
                                   {{s.x() / 2, -s.y() / 2, 0}, -x, s.x()}};
  for (std::size_t w = 0; w < walls.size(); ++w) {
    room.push_back(Rectangle(RoomSurface::kWall,
                             static_cast<int>(w),
                             walls[w].origin,
                             walls[w].along,
                             z,
                             {walls[w].length_m, s.z()}));
  }
  Random random(description.seed, "posters", 0);
  for (int i = 0; i < description.num_posters; ++i) {
    const Wall& wall = walls[static_cast<std::size_t>(i) % walls.size()];
    const int num_on_wall = (description.num_posters - i % 4 + 3) / 4;
    const double slot_m = wall.length_m / num_on_wall;
    const Eigen::Vector2d extent(std::min(random.Uniform(0.5, 1.1), 0.7 * slot_m),
                                 std::min(random.Uniform(0.5, 0.9), 0.4 * s.z()));
    const double along_m = slot_m * (i / 4) + random.Uniform(0.1, 0.9) * (slot_m - extent.x());
    const double up_m = random.Uniform(0.35, 0.5) * s.z();
    const Eigen::Vector3d inward = wall.along.cross(z);
    const Eigen::Vector3d origin =
        wall.origin + along_m * wall.along + up_m * z + kPosterGapM * inward;
    room.push_back(Rectangle(RoomSurface::kPoster, i, origin, wall.along, z, extent));
  }
  return room;
}

bool InsideRoom(const Eigen::Vector3d& p_world,
                const Eigen::Vector3d& room_size_m,
                double margin_m) {
  return std::abs(p_world.x()) <= room_size_m.x() / 2 - margin_m &&
         std::abs(p_world.y()) <= room_size_m.y() / 2 - margin_m && p_world.z() >= margin_m &&
         p_world.z() <= room_size_m.z() - margin_m;
}

Status CheckPath(const World& world) {
  const std::vector<Pose3> path = CameraPath(world.description);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector3d& place = path[i].translation_m;
    if (!InsideRoom(place, world.description.room_size_m, kCameraMarginM)) {
      return InvalidInput(
          fmt::format("camera leaves the room in frame {} at ({:.2f}, {:.2f}, {:.2f}) m; make the "
                      "orbit's radius or height smaller, or the room larger",
                      i,
                      place.x(),
                      place.y(),
                      place.z()));
    }
    for (const PlacedObject& object : world.objects) {
      const Eigen::Vector3d p_object = object.world_from_object.Inverse() * place;
      if ((p_object.cwiseAbs() - object.size_m / 2).maxCoeff() > kCameraMarginM) continue;
      return InvalidInput(
          fmt::format("camera enters {} '{}' in frame {}; change the orbit or the object's place",
                      object.class_name,
                      object.model,
                      i));
    }
  }
  return Ok();
}

}  // namespace

Result<World> BuildWorld(const SceneDescription& description,
                         const std::map<std::string, FurnitureModel>& models) {
  World world{description, {}, MakeRoom(description)};
  for (const SceneObject& wanted : description.objects) {
    const auto found = models.find(wanted.model);
    if (found == models.end()) {
      return InvalidInput(
          fmt::format("line {} of the scene: model '{}' is not in the catalogues; is the furniture "
                      "package installed?",
                      wanted.line,
                      wanted.model));
    }
    const FurnitureModel& model = found->second;
    const double yaw_rad = wanted.yaw_deg * std::numbers::pi / 180.0;
    PlacedObject object{wanted.class_name, wanted.model, model.mesh, model.size_m, Pose3()};
    object.world_from_object.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
    object.world_from_object.translation_m = {
        wanted.position_m.x(), wanted.position_m.y(), model.size_m.z() / 2};
    for (const Eigen::Vector3f& vertex : object.mesh.vertices) {
      const Eigen::Vector3d p_world = object.world_from_object * vertex.cast<double>();
      if (InsideRoom(p_world, description.room_size_m, -1e-3)) continue;
      return InvalidInput(fmt::format(
          "line {} of the scene: {} '{}' stands in or beyond a wall; change its position_m",
          wanted.line,
          wanted.class_name,
          wanted.model));
    }
    world.objects.push_back(std::move(object));
  }
  const Status path = CheckPath(world);
  if (!path) return path.error();
  return world;
}

}  // namespace deepslam::synth
