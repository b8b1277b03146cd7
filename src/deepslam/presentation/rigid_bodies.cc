#include "deepslam/presentation/rigid_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <utility>

#include <Eigen/Geometry>

#include "deepslam/convex/convex_hull.h"
#include "deepslam/convex/mass_properties.h"
#include "deepslam/convex/separate.h"
#include "deepslam/core/check.h"
#include "deepslam/core/parallel.h"
#include "deepslam/geometry/box.h"
#include "deepslam/presentation/layout_parts.h"
#include "deepslam/shape/mesh_check.h"

namespace deepslam::presentation {
namespace {

// Feet end unevenly by what voxels and depth leave; a foot that was not seen ends higher.
constexpr std::array kFootBands_m = {0.01, 0.025, 0.05, 0.1};
constexpr double kFooting_m = 0.02;  // the centre of mass lies so far within what it stands on
// Between things: margins of engines are 1 mm a body, and lift it off the floor by as much.
constexpr double kBodyGap_m = 0.004;
constexpr double kSmallestPiece_m = 0.002;  // engines take nothing thinner
constexpr double kLeastMass_kg = 0.01;  // engines go unstable with lighter bodies beside heavy ones
constexpr double kPartDensity_kg_m3 = 2000;  // of masonry; parts never move

TriangleMesh InFrame(TriangleMesh mesh, const Pose3& b_from_a) {
  for (Eigen::Vector3f& p : mesh.vertices) p = (b_from_a * p.cast<double>()).cast<float>();
  return mesh;
}

double BottomOf(const std::vector<TriangleMesh>& pieces) {
  double bottom_m = std::numeric_limits<double>::infinity();
  for (const TriangleMesh& piece : pieces) {
    for (const Eigen::Vector3f& p : piece.vertices)
      bottom_m = std::min(bottom_m, static_cast<double>(p.z()));
  }
  return bottom_m;
}

// Mass and inertia of the mesh, or of its pieces where it has no inside.
RigidBody BodyOf(const TriangleMesh& mesh, std::vector<TriangleMesh> pieces, double density_kg_m3) {
  convex::MassProperties properties;
  if (shape::CheckMesh(mesh).ok()) properties = convex::MassPropertiesOf(mesh);
  if (!(properties.volume_m3 > 0) && !pieces.empty())
    properties = convex::MassPropertiesOf(pieces.front());  // the hull of an open mesh
  RigidBody body;
  body.mass_kg = std::max(kLeastMass_kg, density_kg_m3 * properties.volume_m3);
  body.centre_of_mass = properties.centre;
  body.thing_from_axes = properties.mesh_from_axes;
  // Engines refuse moments of zero, and those that break the triangle inequality by rounding.
  const double least = 1e-5 * body.mass_kg;
  body.inertia_kg_m2 = (density_kg_m3 * properties.inertia).cwiseMax(least);
  body.pieces = std::move(pieces);
  return body;
}

// The hull of points on the plan, counter-clockwise (Andrew's monotone chain).
std::vector<Eigen::Vector2d> HullOf(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Eigen::Vector2d> hull;
  for (const bool lower : {true, false}) {
    const std::size_t first = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= first + 2) {
        const Eigen::Vector2d a = hull.back() - hull[hull.size() - 2];
        const Eigen::Vector2d b = p - hull.back();
        if (a.x() * b.y() - a.y() * b.x() > 0) break;
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();  // the next chain begins with it
    if (lower) std::reverse(points.begin(), points.end());
  }
  return hull;
}

// Whether a thing whose pieces touch z = `floor_m` stays upright there.
bool Stands(const std::vector<TriangleMesh>& pieces,
            const Eigen::Vector3d& centre,
            double floor_m) {
  constexpr double kTouches_m = 1e-4;  // rounding of vertices, far below what makes a thing lean
  std::vector<Eigen::Vector2d> points;
  for (const TriangleMesh& piece : pieces) {
    for (const Eigen::Vector3f& p : piece.vertices) {
      if (p.z() < floor_m + kTouches_m) points.emplace_back(p.x(), p.y());
    }
  }
  if (points.size() < 3) return false;
  const std::vector<Eigen::Vector2d> hull = HullOf(std::move(points));
  if (hull.size() < 3) return false;
  for (std::size_t n = 0; n < hull.size(); ++n) {
    const Eigen::Vector2d along = (hull[(n + 1) % hull.size()] - hull[n]).normalized();
    const Eigen::Vector2d off = centre.head<2>() - hull[n];
    if (along.x() * off.y() - along.y() * off.x() < kFooting_m) return false;
  }
  return true;
}

// What ends within the band ends on the floor.
std::vector<TriangleMesh> WithFlatFeet(const std::vector<TriangleMesh>& pieces,
                                       double floor_m,
                                       double band_m) {
  std::vector<TriangleMesh> flat;
  for (const TriangleMesh& piece : pieces) {
    TriangleMesh pressed = piece;
    bool changed = false;
    for (Eigen::Vector3f& p : pressed.vertices) {
      if (p.z() >= floor_m + band_m) continue;
      p.z() = static_cast<float>(floor_m);
      changed = true;
    }
    if (changed) pressed = convex::ConvexHull(pressed.vertices);
    if (!pressed.empty()) flat.push_back(std::move(pressed));
  }
  return flat;
}

// Pieces of an object in the world, as they stand on the floor; as they are where it would tip
// over.
std::vector<TriangleMesh> OnFloor(std::vector<TriangleMesh> pieces,
                                  const Eigen::Vector3d& centre,
                                  double floor_m) {
  const Pose3 shift = {Eigen::Quaterniond::Identity(), {0, 0, floor_m - BottomOf(pieces)}};
  std::vector<TriangleMesh> moved;
  for (const TriangleMesh& piece : pieces) moved.push_back(InFrame(piece, shift));
  for (const double band_m : kFootBands_m) {
    std::vector<TriangleMesh> flat = WithFlatFeet(moved, floor_m, band_m);
    if (Stands(flat, centre, floor_m)) return flat;
  }
  return pieces;
}

// What bears the object: the endless floor at 0, or the floor of its room where that is higher.
double FloorOf(const CompactMap& map, const CompactObject& object) {
  if (!object.room || !map.layout) return 0;
  return std::max(0.0,
                  TopOfFloor(map.layout->rooms[static_cast<std::size_t>(*object.room)].floor_m));
}

bool IsTooThin(const TriangleMesh& piece) {
  Box3 box;
  for (const Eigen::Vector3f& p : piece.vertices) box.Extend(p.cast<double>());
  return !(box.Size().minCoeff() > kSmallestPiece_m);
}

class BodyMaker {
 public:
  BodyMaker(const CompactMap& map,
            std::span<const TriangleMesh> meshes,
            std::span<const gltf::GltfPart> parts,
            const ClassTable& classes)
      : map_(map), meshes_(meshes), parts_(parts), classes_(classes) {}

  [[nodiscard]] RigidBodies Make(const convex::DecomposeOptions& options) && {
    Decompose(options);
    std::vector<convex::PiecedThing> things;
    for (std::size_t n = 0; n < bodies_.objects.size(); ++n) things.push_back(ObjectInWorld(n));
    for (std::size_t n = 0; n < parts_.size(); ++n) {
      // Things rest on floors: cut along them they would no longer touch.
      if (parts_[n].kind != "floor") things.push_back({bodies_.parts[n].pieces, true});
    }
    convex::Separate(things, kBodyGap_m);
    for (std::size_t n = 0; n < bodies_.objects.size(); ++n) TakeBack(n, things[n].pieces);
    return std::move(bodies_);
  }

 private:
  void Decompose(const convex::DecomposeOptions& options) {
    const std::size_t num_objects = meshes_.size();
    std::vector<RigidBody> all(num_objects + parts_.size());
    ParallelFor(all.size(), [&](std::size_t n) {
      const bool is_object = n < num_objects;
      const TriangleMesh& mesh = is_object ? meshes_[n] : parts_[n - num_objects].mesh_world;
      const ObjectClass* known = is_object ? classes_.Find(map_.objects[n].class_name) : nullptr;
      const ClassPhysics physics = known == nullptr ? ClassPhysics() : known->physics;
      all[n] = BodyOf(mesh,
                      convex::Decompose(mesh, options),
                      is_object ? physics.density_kg_m3 : kPartDensity_kg_m3);
      if (is_object) all[n].free = CanMove(map_.objects[n], physics) && !all[n].pieces.empty();
    });
    for (std::size_t n = 0; n < all.size(); ++n)
      (n < num_objects ? bodies_.objects : bodies_.parts).push_back(std::move(all[n]));
  }

  [[nodiscard]] bool CanMove(const CompactObject& object, const ClassPhysics& physics) const {
    return map_.ground_world && !physics.fixed && !object.stands_on.empty() &&
           object.stands_on != kOnWall;
  }

  [[nodiscard]] Eigen::Vector3d CentreOf(std::size_t n) const {
    return map_.objects[n].world_from_object * bodies_.objects[n].centre_of_mass;
  }

  [[nodiscard]] convex::PiecedThing ObjectInWorld(std::size_t n) const {
    const RigidBody& body = bodies_.objects[n];
    const CompactObject& object = map_.objects[n];
    convex::PiecedThing thing{{}, !body.free};
    for (const TriangleMesh& piece : body.pieces)
      thing.pieces.push_back(InFrame(piece, object.world_from_object));
    if (body.free && object.stands_on == kOnFloor)
      thing.pieces = OnFloor(std::move(thing.pieces), CentreOf(n), FloorOf(map_, object));
    return thing;
  }

  void TakeBack(std::size_t n, std::vector<TriangleMesh>& pieces_world) {
    RigidBody& body = bodies_.objects[n];
    const CompactObject& object = map_.objects[n];
    std::erase_if(pieces_world, IsTooThin);
    if (object.stands_on == kOnFloor)
      body.free = body.free && Stands(pieces_world, CentreOf(n), FloorOf(map_, object));
    body.free = body.free && !pieces_world.empty();
    body.pieces.clear();
    for (TriangleMesh& piece : pieces_world)
      body.pieces.push_back(InFrame(std::move(piece), object.world_from_object.Inverse()));
  }

  const CompactMap& map_;
  std::span<const TriangleMesh> meshes_;
  std::span<const gltf::GltfPart> parts_;
  const ClassTable& classes_;
  RigidBodies bodies_;
};

}  // namespace

RigidBodies MakeRigidBodies(const CompactMap& map,
                            std::span<const TriangleMesh> meshes,
                            std::span<const gltf::GltfPart> parts,
                            const ClassTable& classes,
                            const convex::DecomposeOptions& options) {
  DEEPSLAM_CHECK(meshes.size() == map.objects.size(), "one mesh per object");
  return BodyMaker(map, meshes, parts, classes).Make(options);
}

}  // namespace deepslam::presentation
