// What engines are told of the things of a map. That they stay where they stand is shown in
// tests/exports.
#include "deepslam/presentation/rigid_bodies.h"

#include <limits>

#include <gtest/gtest.h>

#include "deepslam/convex/convex_hull.h"
#include "deepslam/presentation/labelled_scene.h"
#include "deepslam/presentation/scenes_elsewhere.h"
#include "deepslam/shape/mesh_check.h"
#include "presentation/room_with_box.h"

namespace deepslam::presentation {
namespace {

// Cubes of a metre whose middles lie at these places.
struct Cubes {
  CompactMap map;
  std::vector<TriangleMesh> meshes;

  explicit Cubes(const std::vector<Eigen::Vector3d>& places) {
    map.ground_world = Plane{};
    const TriangleMesh cube = *mesh::MakeObjectMesh(CubeGrid(), kCubeScaleM, {});
    for (const Eigen::Vector3d& place : places) {
      CompactObject object;
      object.id = ObjectId{static_cast<int>(meshes.size())};
      object.name = "cabinet_" + std::to_string(meshes.size());
      object.class_name = "cabinet";
      object.world_from_object.translation_m = place;
      object.stands_on = kOnFloor;
      map.objects.push_back(object);
      meshes.push_back(cube);
    }
  }
  [[nodiscard]] RigidBodies Bodies(const ClassTable& classes = OneClass()) const {
    return MakeRigidBodies(map, meshes, {}, classes, {});
  }
};

// Lowest and highest place of the pieces in the world along an axis.
std::pair<double, double> SpanOf(const RigidBody& body, const CompactObject& object, int axis) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const TriangleMesh& piece : body.pieces) {
    for (const Eigen::Vector3f& p : piece.vertices) {
      const double place = (object.world_from_object * p.cast<double>())[axis];
      low = std::min(low, place);
      high = std::max(high, place);
    }
  }
  return {low, high};
}

TEST(MakeRigidBodies, WeighWhatTheirClassSays) {
  ClassTable classes = OneClass();
  classes.classes[0].physics.density_kg_m3 = 100;
  const RigidBody body = Cubes({{0, 0, 0.5}}).Bodies(classes).objects[0];
  EXPECT_TRUE(body.free);
  EXPECT_NEAR(body.mass_kg, 100, 5);
  EXPECT_NEAR(body.inertia_kg_m2.x(), 100.0 / 6, 2);
  EXPECT_LT(body.centre_of_mass.norm(), 0.02);
  classes.classes[0].physics.fixed = true;
  EXPECT_FALSE(Cubes({{0, 0, 0.5}}).Bodies(classes).objects[0].free);
}

TEST(MakeRigidBodies, WhatStandsOnTheFloorTouchesIt) {
  // Six centimetres too high, and too low.
  const Cubes cubes({{0, 0, 0.56}, {5, 0, 0.44}});
  const RigidBodies bodies = cubes.Bodies();
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_TRUE(bodies.objects[n].free);
    EXPECT_NEAR(SpanOf(bodies.objects[n], cubes.map.objects[n], 2).first, 0, 1e-5);
  }
}

TEST(MakeRigidBodies, WhatWouldFallOrTipStays) {
  Cubes cubes({{0, 0, 1.5}, {5, 0, 1.5}, {10, 0, 0.5}});
  cubes.map.objects[0].stands_on = "";
  cubes.map.objects[1].stands_on = kOnWall;
  // An arm on one side, heavier than the foot.
  for (Eigen::Vector3f& p : cubes.meshes[2].vertices) {
    if (p.z() < 0) p.x() = 0.4F + 0.1F * p.x();
  }
  const RigidBodies bodies = cubes.Bodies();
  for (const RigidBody& body : bodies.objects) EXPECT_FALSE(body.free);
  cubes.map.objects[0].stands_on = kOnFloor;
  cubes.map.ground_world.reset();
  EXPECT_FALSE(cubes.Bodies().objects[0].free) << "no ground was seen";
}

TEST(MakeRigidBodies, NothingReachesIntoAnother) {
  const Cubes cubes({{0, 0, 0.5}, {0.9, 0, 0.5}});
  const RigidBodies bodies = cubes.Bodies();
  // They overlapped by 10 cm; the plane between them is one along a face, which may lean a little.
  EXPECT_LT(SpanOf(bodies.objects[0], cubes.map.objects[0], 0).second - 0.01,
            SpanOf(bodies.objects[1], cubes.map.objects[1], 0).first);
  EXPECT_TRUE(bodies.objects[0].free && bodies.objects[1].free);
}

TEST(MakeRigidBodies, BearsMeshesThatAreEmptyOrOpenAndNone) {
  EXPECT_TRUE(Cubes({}).Bodies().objects.empty());
  Cubes cubes({{0, 0, 0.5}, {5, 0, 0.5}});
  cubes.meshes[0] = {};
  cubes.meshes[1].faces.resize(cubes.meshes[1].faces.size() / 2);
  const RigidBodies bodies = cubes.Bodies();
  EXPECT_FALSE(bodies.objects[0].free);
  EXPECT_TRUE(bodies.objects[0].pieces.empty());
  EXPECT_EQ(bodies.objects[1].pieces.size(), 1U) << "the hull";
  EXPECT_GT(bodies.objects[1].mass_kg, 0);
  EXPECT_GT(bodies.objects[1].inertia_kg_m2.minCoeff(), 0);
}

TEST(MakeRigidBodies, AThousandObjects) {
  std::vector<Eigen::Vector3d> places;
  for (int n = 0; n < 1000; ++n) places.emplace_back(1.1 * (n % 40), 1.1 * (n / 40), 0.5);
  Cubes cubes(places);
  std::vector<Eigen::Vector3f> corners;
  for (const float x : {-0.5F, 0.5F}) {
    for (const float y : {-0.5F, 0.5F})
      corners.insert(corners.end(), {{x, y, -0.5F}, {x, y, 0.5F}});
  }
  cubes.meshes.assign(places.size(), convex::ConvexHull(corners));  // of few faces: it is many
  const RigidBodies bodies = cubes.Bodies();
  ASSERT_EQ(bodies.objects.size(), 1000U);
  for (const RigidBody& body : bodies.objects) ASSERT_TRUE(body.free);
}

TEST(ScenesElsewhere, HaveWhatTheMapHas) {
  const FinishedMap finished = RoomWithBox();
  const gltf::GltfScene scene =
      MakeScene(finished, OneClass(), testing_support::SmallCamera(), SomeRun(), {});
  const CompactMap map = MakeCompactMap(finished, scene, CodesOfRoomWithBox(), {SomeRun(), {}, {}});
  const RigidBodies bodies = MakeRigidBodies(map, finished.meshes, scene.parts, OneClass(), {});
  const usd::UsdScene with_physics = UsdSceneOf(scene, map, &bodies);
  ASSERT_EQ(with_physics.groups.size(), 3U);
  ASSERT_EQ(with_physics.groups[0].prims.size(), 1U);
  EXPECT_EQ(with_physics.groups[0].prims[0].name, "cabinet_03");
  EXPECT_EQ(with_physics.groups[0].prims[0].label, "cabinet");
  EXPECT_TRUE(with_physics.groups[0].prims[0].body.has_value());
  EXPECT_FALSE(UsdSceneOf(scene, map, nullptr).groups[0].prims[0].body.has_value());
  const simulator::SimulatorScene simulated = SimulatorSceneOf(scene, map, bodies);
  ASSERT_EQ(simulated.things.size(), 1U);
  EXPECT_EQ(simulated.things[0].colour, (Rgb8{200, 0, 0}));
  EXPECT_TRUE(simulated.has_floor);
}

}  // namespace
}  // namespace deepslam::presentation
