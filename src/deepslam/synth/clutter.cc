#include "deepslam/synth/clutter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "deepslam/core/random.h"
#include "deepslam/synth/table_top.h"

namespace deepslam::synth {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kTries = 20;     // random places, after which a thing is left out
constexpr int kCupSides = 20;  // faces of its wall: round in pictures

Rgb8 SomeColour(Random& random) {
  const auto byte = [&] { return static_cast<std::uint8_t>(40 + random.Index(190)); };
  const std::uint8_t r = byte();
  const std::uint8_t g = byte();
  return {r, g, byte()};
}

// A box of the given size on z = 0, faces in two shades.
TriangleMesh Box(const Eigen::Vector3d& size_m, const Rgb8& colour) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p((corner & 1 ? 0.5 : -0.5) * size_m.x(),
                            (corner & 2 ? 0.5 : -0.5) * size_m.y(),
                            corner & 4 ? size_m.z() : 0.0);
    mesh.vertices.push_back(p.cast<float>());
    mesh.colours.push_back(colour);
  }
  mesh.faces = {{0, 2, 1},
                {1, 2, 3},
                {4, 5, 6},
                {5, 7, 6},
                {0, 1, 4},
                {1, 5, 4},
                {2, 6, 3},
                {3, 6, 7},
                {0, 4, 2},
                {2, 4, 6},
                {1, 3, 5},
                {3, 7, 5}};
  return mesh;
}

// An open cup: wall and bottom.
TriangleMesh Cup(double radius_m, double height_m, const Rgb8& colour) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0f, 0.0f, 0.004f);
  for (int i = 0; i < kCupSides; ++i) {
    const double angle = 2 * kPi * i / kCupSides;
    const Eigen::Vector3d rim(radius_m * std::cos(angle), radius_m * std::sin(angle), height_m);
    mesh.vertices.push_back(Eigen::Vector3d(0.85 * rim.x(), 0.85 * rim.y(), 0).cast<float>());
    mesh.vertices.push_back(rim.cast<float>());
  }
  for (std::uint32_t i = 0; i < kCupSides; ++i) {
    const std::uint32_t a = 1 + 2 * i;
    const std::uint32_t b = 1 + 2 * ((i + 1) % kCupSides);
    mesh.faces.push_back({a, b, a + 1});
    mesh.faces.push_back({b, b + 1, a + 1});
    mesh.faces.push_back({0, a, b});
  }
  mesh.colours.assign(mesh.vertices.size(), colour);
  return mesh;
}

TriangleMesh SomeThing(Random& random) {
  switch (random.Index(3)) {
    case 0:  // a pile of books is one book too thick
      return Box(
          {random.Uniform(0.14, 0.22), random.Uniform(0.2, 0.3), random.Uniform(0.015, 0.06)},
          SomeColour(random));
    case 1:
      return Cup(random.Uniform(0.035, 0.045), random.Uniform(0.08, 0.11), SomeColour(random));
    default:
      return Box({random.Uniform(0.08, 0.2), random.Uniform(0.1, 0.25), random.Uniform(0.08, 0.2)},
                 SomeColour(random));
  }
}

void Place(TriangleMesh& thing, const Pose3& world_from_thing) {
  for (Eigen::Vector3f& vertex : thing.vertices)
    vertex = (world_from_thing * vertex.cast<double>()).cast<float>();
}

Pose3 Upright(const Eigen::Vector3d& place, double yaw_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())), place};
}

bool Apart(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& others, double gap_m) {
  return std::all_of(others.begin(), others.end(), [&](const Eigen::Vector2d& other) {
    return (p - other).norm() > gap_m;
  });
}

void AddOnTable(const PlacedObject& table,
                int count,
                Random& random,
                std::vector<TriangleMesh>& clutter) {
  constexpr double kRimM = 0.12;  // of middles from the table's edge, so that things lie on it
  constexpr double kBetweenM = 0.3;  // between middles; only corners of the largest things may meet
  const TableTop top(table.mesh);
  std::vector<Eigen::Vector2d> taken;
  for (int i = 0; i < count; ++i) {
    TriangleMesh thing = SomeThing(random);
    const double yaw_rad = random.Uniform(0, 2 * kPi);
    for (int tries = 0; tries < kTries; ++tries) {
      const Eigen::Vector3d p(random.Uniform(-0.5, 0.5) * table.size_m.x(),
                              random.Uniform(-0.5, 0.5) * table.size_m.y(),
                              table.size_m.z() / 2);
      if (!top.Inside(p, kRimM) || !Apart(p.head<2>(), taken, kBetweenM)) continue;
      taken.push_back(p.head<2>());
      Place(thing, table.world_from_object * Upright(p, yaw_rad));
      clutter.push_back(std::move(thing));
      break;
    }
  }
}

void AddOnFloor(const SceneDescription& description,
                const std::vector<PlacedObject>& objects,
                Random& random,
                std::vector<TriangleMesh>& clutter) {
  constexpr double kWallM = 0.4;     // of middles; half a box's diagonal is 0.28
  constexpr double kBesideM = 0.25;  // of middles from furniture's box
  std::vector<Eigen::Vector2d> taken;
  for (int i = 0; i < description.clutter.num_floor_boxes; ++i) {
    TriangleMesh box =
        Box({random.Uniform(0.2, 0.4), random.Uniform(0.2, 0.4), random.Uniform(0.12, 0.3)},
            SomeColour(random));
    const double yaw_rad = random.Uniform(0, 2 * kPi);
    for (int tries = 0; tries < kTries; ++tries) {
      const Eigen::Vector2d p(
          random.Uniform(-0.5, 0.5) * (description.room_size_m.x() - 2 * kWallM),
          random.Uniform(-0.5, 0.5) * (description.room_size_m.y() - 2 * kWallM));
      const bool free =
          std::none_of(objects.begin(), objects.end(), [&](const PlacedObject& object) {
            const Eigen::Vector3d at =
                object.world_from_object.Inverse() * Eigen::Vector3d(p.x(), p.y(), 0);
            return (at.head<2>().cwiseAbs() - object.size_m.head<2>() / 2).maxCoeff() < kBesideM;
          });
      if (!free || !Apart(p, taken, 0.6)) continue;
      taken.push_back(p);
      Place(box, Upright({p.x(), p.y(), 0}, yaw_rad));
      clutter.push_back(std::move(box));
      break;
    }
  }
}

}  // namespace

std::vector<TriangleMesh> MakeClutter(const SceneDescription& description,
                                      const std::vector<PlacedObject>& objects) {
  std::vector<TriangleMesh> clutter;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (!objects[i].has_support_plane) continue;
    Random random(description.seed, "table clutter", i);
    AddOnTable(objects[i], description.clutter.num_per_table, random, clutter);
  }
  Random random(description.seed, "floor clutter", 0);
  AddOnFloor(description, objects, random, clutter);
  return clutter;
}

}  // namespace deepslam::synth
