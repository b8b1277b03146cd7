#include "deepslam/synth/world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/angles.h"
#include "deepslam/core/random.h"
#include "deepslam/synth/camera_clearance.h"
#include "deepslam/synth/camera_path.h"
#include "deepslam/synth/clutter.h"

namespace deepslam::synth {
namespace {

constexpr double kCameraMarginM = 0.1;    // nearer to a surface a picture shows nothing else
constexpr double kWallThicknessM = 0.15;  // how deep openings of outer walls are lined
constexpr double kLeafDepth = 0.4;        // share of the wall's thickness behind its face
constexpr std::size_t kMaxObjects = 254;  // truth/instances counts in bytes
constexpr double kPosterGapM = 0.004;     // before its wall
// Furniture beyond these is in another unit than metres.
constexpr double kMinSizeM = 0.05;
constexpr double kMaxSizeM = 20;  // a chair in inches is 35

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

void AddQuad(const Eigen::Vector3d& origin,
             const Eigen::Vector3d& u,
             const Eigen::Vector3d& v,
             TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Eigen::Vector3d& p : {origin,
                                   Eigen::Vector3d(origin + u),
                                   Eigen::Vector3d(origin + u + v),
                                   Eigen::Vector3d(origin + v)}) {
    mesh.vertices.push_back(p.cast<float>());
  }
  mesh.faces.push_back({first, first + 1, first + 2});
  mesh.faces.push_back({first, first + 2, first + 3});
}

// Cuts gaps out of a wall, lines them as deep as the wall is thick, and hangs leaves into those
// that are closed.
void CutGaps(const std::vector<SceneOpening>& here, std::optional<double> depth_m, RoomPart& wall) {
  if (here.empty()) return;
  std::vector<double> us = {0, wall.extent_m.x()};
  std::vector<double> vs = {0, wall.extent_m.y()};
  for (const SceneOpening& opening : here) {
    us.insert(us.end(), {opening.from_m, opening.from_m + opening.width_m});
    vs.insert(vs.end(), {opening.bottom_m, opening.bottom_m + opening.height_m});
  }
  std::sort(us.begin(), us.end());
  std::sort(vs.begin(), vs.end());
  wall.mesh = TriangleMesh();
  for (std::size_t i = 0; i + 1 < us.size(); ++i) {
    for (std::size_t j = 0; j + 1 < vs.size(); ++j) {
      const Eigen::Vector2d middle((us[i] + us[i + 1]) / 2, (vs[j] + vs[j + 1]) / 2);
      const bool open = std::any_of(here.begin(), here.end(), [&](const SceneOpening& o) {
        return middle.x() > o.from_m && middle.x() < o.from_m + o.width_m &&
               middle.y() > o.bottom_m && middle.y() < o.bottom_m + o.height_m;
      });
      if (open || us[i + 1] - us[i] < 1e-9 || vs[j + 1] - vs[j] < 1e-9) continue;
      AddQuad(wall.origin + us[i] * wall.u_axis + vs[j] * wall.v_axis,
              (us[i + 1] - us[i]) * wall.u_axis,
              (vs[j + 1] - vs[j]) * wall.v_axis,
              wall.mesh);
    }
  }
  if (!depth_m) return;  // lined from the other face
  const Eigen::Vector3d out = -*depth_m * wall.u_axis.cross(wall.v_axis);
  for (const SceneOpening& o : here) {
    const Eigen::Vector3d corner = wall.origin + o.from_m * wall.u_axis + o.bottom_m * wall.v_axis;
    const Eigen::Vector3d u = o.width_m * wall.u_axis;
    const Eigen::Vector3d v = o.height_m * wall.v_axis;
    if (o.closed) AddQuad(corner + kLeafDepth * out, u, v, wall.mesh);
    AddQuad(corner, out, v, wall.mesh);
    AddQuad(corner + u, out, v, wall.mesh);
    AddQuad(corner, u, out, wall.mesh);
    AddQuad(corner + v, u, out, wall.mesh);
  }
}

void CutOpenings(const std::vector<SceneOpening>& openings, RoomPart& wall) {
  std::vector<SceneOpening> here;
  std::ranges::copy_if(openings, std::back_inserter(here), [&](const SceneOpening& opening) {
    return opening.wall == wall.number;
  });
  CutGaps(here, kWallThicknessM, wall);
}

// Both faces; the gaps are lined from the first one.
void AddPartition(const ScenePartition& partition,
                  double height_m,
                  int number,
                  std::vector<RoomPart>& room) {
  const Eigen::Vector2d run = partition.to_m - partition.from_m;
  const double length_m = run.norm();
  const Eigen::Vector3d along(run.x() / length_m, run.y() / length_m, 0);
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d aside = 0.5 * partition.thickness_m * along.cross(z);
  const Eigen::Vector3d from(partition.from_m.x(), partition.from_m.y(), 0);
  room.push_back(
      Rectangle(RoomSurface::kWall, number, from + aside, along, z, {length_m, height_m}));
  CutGaps(partition.openings, partition.thickness_m, room.back());
  room.push_back(Rectangle(RoomSurface::kWall,
                           number + 1,
                           from - aside + length_m * along,
                           -along,
                           z,
                           {length_m, height_m}));
  std::vector<SceneOpening> seen_from_behind = partition.openings;
  for (SceneOpening& gap : seen_from_behind) {
    gap.from_m = length_m - gap.from_m - gap.width_m;
    gap.closed = false;  // one leaf a gap
  }
  CutGaps(seen_from_behind, std::nullopt, room.back());
}

Status CheckOpenings(const SceneDescription& description) {
  for (const SceneOpening& opening : description.openings) {
    const double length_m =
        opening.wall % 2 == 0 ? description.room_size_m.y() : description.room_size_m.x();
    if (opening.from_m + opening.width_m <= length_m &&
        opening.bottom_m + opening.height_m <= description.room_size_m.z())
      continue;
    return InvalidInput(
        fmt::format("line {} of the scene: opening reaches beyond its wall of {:.2f} x {:.2f} m; "
                    "change its from_m, width_m, bottom_m or height_m",
                    opening.line,
                    length_m,
                    description.room_size_m.z()));
  }
  for (const ScenePartition& partition : description.partitions) {
    const double length_m = (partition.to_m - partition.from_m).norm();
    for (const SceneOpening& gap : partition.openings) {
      if (gap.from_m + gap.width_m <= length_m &&
          gap.bottom_m + gap.height_m <= description.room_size_m.z())
        continue;
      return InvalidInput(fmt::format(
          "line {} of the scene: opening reaches beyond its partition of {:.2f} x {:.2f} m; change "
          "its from_m, width_m, bottom_m or height_m",
          gap.line,
          length_m,
          description.room_size_m.z()));
    }
  }
  return Ok();
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
    CutOpenings(description.openings, room.back());
  }
  for (std::size_t p = 0; p < description.partitions.size(); ++p) {
    const int number = static_cast<int>(walls.size() + 2 * p);
    AddPartition(description.partitions[p], s.z(), number, room);
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
    const bool over_opening = std::any_of(
        description.openings.begin(), description.openings.end(), [&](const SceneOpening& o) {
          return o.wall == i % 4 && along_m < o.from_m + o.width_m &&
                 along_m + extent.x() > o.from_m;
        });
    if (over_opening) continue;
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

std::string Place(const Eigen::Vector3d& p) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) m", p.x(), p.y(), p.z());
}

Status CheckPath(World& world) {
  const std::vector<Pose3> path = CameraPath(world.description);
  std::map<std::size_t, CameraClearance> clearances;  // of objects in whose box the camera comes
  bool was_inside = true;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector3d& place = path[i].translation_m;
    const bool inside = InsideRoom(place, world.description.room_size_m, kCameraMarginM);
    if (!inside && was_inside) {
      world.warnings.push_back(fmt::format(
          "the camera comes to a wall, floor or ceiling, or through it, in frame {} at {}; make "
          "the orbit smaller, move the walk's points or enlarge the room if it should not",
          i,
          Place(place)));
    }
    was_inside = inside;
    for (std::size_t o = 0; o < world.objects.size(); ++o) {
      const PlacedObject& object = world.objects[o];
      const Eigen::Vector3d p_object = object.world_from_object.Inverse() * place;
      if ((p_object.cwiseAbs() - object.size_m / 2).maxCoeff() > kCameraMarginM) continue;
      const auto& clearance = clearances.try_emplace(o, object.mesh).first->second;
      if (!clearance.Blocked(p_object, kCameraMarginM)) continue;
      return InvalidInput(
          fmt::format("camera enters {} '{}' in frame {} at {}; change the way (orbit, walk) or "
                      "the object's place",
                      object.class_name,
                      object.model,
                      i,
                      Place(place)));
    }
  }
  return Ok();
}

// The model at the size the scene asks for.
PlacedObject Sized(const SceneObject& wanted, const FurnitureModel& model) {
  PlacedObject object{
      wanted.class_name, wanted.model, model.mesh, model.size_m, Pose3(), model.shiny};
  if (!wanted.size_m) return object;
  const Eigen::Vector3f stretch = wanted.size_m->cwiseQuotient(model.size_m).cast<float>();
  for (Eigen::Vector3f& vertex : object.mesh.vertices) vertex = vertex.cwiseProduct(stretch);
  object.size_m = *wanted.size_m;
  return object;
}

}  // namespace

Result<World> BuildWorld(const SceneDescription& description,
                         const std::map<std::string, FurnitureModel>& models,
                         const ClassTable& classes) {
  const Status openings = CheckOpenings(description);
  if (!openings) return openings.error();
  if (description.objects.size() > kMaxObjects)
    return InvalidInput(fmt::format("scene has {} objects, more than {}; leave some out",
                                    description.objects.size(),
                                    kMaxObjects));
  World world{description, {}, MakeRoom(description), {}, {}};
  for (const SceneObject& wanted : description.objects) {
    const auto found = models.find(wanted.model);
    if (found == models.end()) {
      return InvalidInput(
          fmt::format("line {} of the scene: model '{}' is not in the catalogues, nor a file; is "
                      "the furniture package installed?",
                      wanted.line,
                      wanted.model));
    }
    const FurnitureModel& model = found->second;
    const double yaw_rad = wanted.yaw_deg * kRadPerDeg;
    PlacedObject object = Sized(wanted, model);
    object.has_support_plane = classes.TraitsOf(wanted.class_name).support_plane;
    const double longest_m = object.size_m.maxCoeff();
    if (longest_m < kMinSizeM || longest_m > kMaxSizeM) {
      return InvalidInput(
          fmt::format("line {} of the scene: {} '{}' is {:.4g} x {:.4g} x {:.4g} m large; is its "
                      "file in another unit than metres? Give it a size_m",
                      wanted.line,
                      wanted.class_name,
                      wanted.model,
                      object.size_m.x(),
                      object.size_m.y(),
                      object.size_m.z()));
    }
    object.world_from_object.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
    object.world_from_object.translation_m = {
        wanted.position_m.x(), wanted.position_m.y(), wanted.bottom_m + object.size_m.z() / 2};
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
  world.clutter = MakeClutter(description, world.objects);
  return world;
}

TriangleMesh RoomMesh(const World& world) {
  TriangleMesh room;
  for (const RoomPart& part : world.room) {
    const auto first = static_cast<std::uint32_t>(room.vertices.size());
    room.vertices.insert(room.vertices.end(), part.mesh.vertices.begin(), part.mesh.vertices.end());
    for (const std::array<std::uint32_t, 3>& f : part.mesh.faces)
      room.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  }
  return room;
}

}  // namespace deepslam::synth
