#include "deepslam/presentation/layout_parts.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "deepslam/gltf/validate.h"
#include "deepslam/presentation/compact_layout.h"
#include "deepslam/presentation/labelled_scene.h"
#include "presentation/room_with_box.h"
#include "support/layout_samples.h"

namespace deepslam::presentation {
namespace {

using testing::IsEmpty;

const gltf::GltfPart* Named(const std::vector<gltf::GltfPart>& parts, const std::string& name) {
  const auto found = std::ranges::find(parts, name, &gltf::GltfPart::name);
  return found == parts.end() ? nullptr : &*found;
}

TEST(LayoutParts, AreClosedAndNamed) {
  const std::vector<gltf::GltfPart> parts =
      LayoutParts(testing_support::TwoRoomLayout(), TriangleMesh());
  EXPECT_EQ(parts.size(), 8U + 2U + 4U);
  for (const char* name : {"wall_00", "wall_07", "door_00", "window_01", "floor_01", "ceiling_00"})
    EXPECT_NE(Named(parts, name), nullptr) << name;
  gltf::GltfScene scene;
  scene.parts = parts;
  for (const bool draco : {true, false}) {
    const gltf::ValidationReport report =
        gltf::ValidateGlb(*gltf::WriteGlb(scene, {.draco = draco}));
    EXPECT_THAT(report.errors, IsEmpty());
    EXPECT_THAT(report.warnings, IsEmpty());
    EXPECT_EQ(report.parts.size(), parts.size());
    EXPECT_EQ(report.num_objects, 0);
  }
}

// The measured ground is at z = 0. A floor that was found 2 cm above it is that floor, one of half
// a metre another.
TEST(LayoutParts, FloorsLieBelowTheMeasuredGround) {
  Layout layout = testing_support::TwoRoomLayout();
  layout.rooms[0].floor_m = 0.02;
  layout.rooms[1].floor_m = 0.5;
  const std::vector<gltf::GltfPart> parts = LayoutParts(layout, TriangleMesh());
  const auto top_of = [&](const char* name) {
    const std::vector<Eigen::Vector3f>& vertices = Named(parts, name)->mesh_world.vertices;
    return std::ranges::max(vertices, {}, [](const Eigen::Vector3f& p) { return p.z(); }).z();
  };
  EXPECT_LT(top_of("floor_00"), -0.005);
  EXPECT_GT(top_of("floor_00"), -0.05);
  EXPECT_NEAR(top_of("floor_01"), 0.5, 0.05);
}

// The door is a hole in both faces of its wall, and nothing of a slab stands in a room.
TEST(LayoutParts, WallsStandBehindTheirFacesAndHaveTheirOpenings) {
  const Layout layout = testing_support::TwoRoomLayout();
  const std::vector<gltf::GltfPart> parts = LayoutParts(layout, TriangleMesh());
  for (const gltf::GltfPart& part : parts) {
    if (part.kind != "wall") continue;
    for (const Eigen::Vector3f& p : part.mesh_world.vertices) {
      for (const LayoutRoom& room : layout.rooms) {
        const Eigen::Vector2d middle(room.polygon_m[0].x() + 2, 1.5);
        EXPECT_FALSE((p.head<2>().cast<double>() - middle).cwiseAbs().x() < 1.999 &&
                     (p.head<2>().cast<double>() - middle).cwiseAbs().y() < 1.499)
            << part.name;
      }
    }
  }
  for (const char* name : {"wall_01", "wall_07"}) {
    const gltf::GltfPart* wall = Named(parts, name);
    const auto has_corner = [&](float y, float z) {
      return std::ranges::any_of(wall->mesh_world.vertices, [&](const Eigen::Vector3f& p) {
        return std::abs(p.y() - y) < 1e-4F && std::abs(p.z() - z) < 1e-4F;
      });
    };
    EXPECT_TRUE(has_corner(1.0F, 2.0F)) << name;
    EXPECT_TRUE(has_corner(1.9F, 2.0F)) << name;
  }
}

TEST(LayoutParts, OfAnOutlineThatCrossesItselfGoWithoutItsFloor) {
  Layout layout;
  LayoutRoom room;
  room.polygon_m = {{0, 0}, {2, 2}, {2, 0}, {0, 2}};
  room.ceiling_m = 2;
  layout.rooms = {room};
  EXPECT_THAT(LayoutParts(layout, TriangleMesh()), IsEmpty());
  EXPECT_THAT(LayoutParts(Layout(), TriangleMesh()), IsEmpty());
}

// A layout whose wall is the measured one.
FinishedMap WithLayout() {
  FinishedMap finished = RoomWithBox();
  LayoutWall wall;
  wall.from_m = {3, 3};
  wall.to_m = {-3, 3};
  wall.top_m = 2;
  wall.confidence = 0.9;
  finished.layout_world.walls = {wall};
  return finished;
}

gltf::GltfScene SceneOf(const FinishedMap& finished, Surroundings surroundings) {
  SceneOptions options;
  options.surroundings = surroundings;
  return MakeScene(finished, OneClass(), testing_support::SmallCamera(), SomeRun(), options);
}

std::size_t FacesOnWall(const gltf::GltfScene& scene) {
  if (!scene.room) return 0;
  return static_cast<std::size_t>(std::ranges::count_if(scene.room->faces, [&](const auto& face) {
    const Eigen::Vector3f& p = scene.room->vertices[face[0]];
    return std::abs(p.y() - 3) < 1e-3F && p.z() > 0.1F;
  }));
}

TEST(MakeScene, ShowsTheLayoutTheMeasuredSurfaceOrBoth) {
  const FinishedMap finished = WithLayout();
  const gltf::GltfScene measured = SceneOf(finished, Surroundings::kMeasured);
  EXPECT_THAT(measured.parts, IsEmpty());
  EXPECT_GT(FacesOnWall(measured), 0U);
  const gltf::GltfScene layout = SceneOf(finished, Surroundings::kLayout);
  EXPECT_EQ(layout.parts.size(), 1U);
  EXPECT_FALSE(layout.room.has_value());
  const gltf::GltfScene both = SceneOf(finished, Surroundings::kBoth);
  EXPECT_EQ(both.parts.size(), 1U);
  EXPECT_EQ(FacesOnWall(both), 0U) << "the wall is there once";
  EXPECT_FALSE(both.parts[0].mesh_world.colours.empty()) << "in the measured colours";
  for (const gltf::GltfScene& scene : {measured, layout, both}) {
    EXPECT_EQ(scene.objects.size(), 1U);
    EXPECT_TRUE(gltf::ValidateGlb(*gltf::WriteGlb(scene, {})).ok());
  }
}

TEST(MakeScene, WithoutALayoutShowsTheMeasuredSurface) {
  EXPECT_TRUE(SceneOf(RoomWithBox(), Surroundings::kLayout).room.has_value());
}

TEST(CompactLayout, GivesBackWhatTheSceneAndThePlanNeed) {
  Layout layout = testing_support::TwoRoomLayout();
  layout.rooms[1].ceiling_m = 0;
  layout.walls.erase(layout.walls.begin() + 2);  // the first room's side was not seen
  layout.openings[1].wall = 5;
  layout.rooms[0].guessed[2] = true;
  const Layout again = LayoutOf(CompactLayoutOf(layout));
  ASSERT_EQ(again.rooms.size(), 2U);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_EQ(again.rooms[n].polygon_m, layout.rooms[n].polygon_m);
    EXPECT_EQ(again.rooms[n].guessed, layout.rooms[n].guessed);
    EXPECT_EQ(again.rooms[n].ceiling_m, layout.rooms[n].ceiling_m);
  }
  ASSERT_EQ(again.walls.size(), layout.walls.size());
  for (std::size_t n = 0; n < layout.walls.size(); ++n) EXPECT_EQ(again.walls[n], layout.walls[n]);
  ASSERT_EQ(again.openings.size(), 2U);
  EXPECT_EQ(again.openings[1].kind, OpeningKind::kWindow);
  EXPECT_EQ(again.openings[1].wall, 5);
}

}  // namespace
}  // namespace deepslam::presentation
