#include "deepslam/presentation/labelled_scene.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "deepslam/gltf/validate.h"
#include "deepslam/presentation/room_beside.h"
#include "presentation/room_with_box.h"

namespace deepslam::presentation {
namespace {

gltf::GltfScene Scene(const FinishedMap& finished, const SceneOptions& options = {}) {
  return MakeScene(finished, OneClass(), testing_support::SmallCamera(), SomeRun(), options);
}

TEST(MakeScene, HoldsObjectsRoomFloorAndPath) {
  const FinishedMap finished = RoomWithBox();
  const gltf::GltfScene scene = Scene(finished);
  ASSERT_EQ(scene.objects.size(), 1U);
  const gltf::GltfObject& object = scene.objects[0];
  EXPECT_EQ(object.name, "cabinet_03");
  EXPECT_EQ(object.instance, 3);
  EXPECT_EQ(object.source, "fused");
  EXPECT_EQ(object.class_colour, (Rgb8{10, 20, 30}));
  EXPECT_THAT(object.views, testing::ElementsAre(0, 2));
  EXPECT_EQ(object.mesh.vertices, finished.meshes[0].vertices);
  EXPECT_EQ(object.mesh.colours, finished.meshes[0].colours);
  ASSERT_TRUE(scene.ground.has_value());
  for (const Eigen::Vector3f& p : scene.ground->vertices) {
    EXPECT_EQ(p.z(), 0);
    EXPECT_LT(p.head<2>().cwiseAbs().maxCoeff(), 3.2F);
  }
  EXPECT_EQ(scene.trajectory_world_from_camera.size(), finished.map.frames.size());
  EXPECT_EQ(scene.keyframes.size(), finished.map.keyframes.size());
  EXPECT_EQ(scene.generator, "deepslam 0.1.0");
  EXPECT_EQ(scene.provenance.at("capture_sha256"), "ab12");
  const gltf::ValidationReport report = gltf::ValidateGlb(*gltf::WriteGlb(scene, {}));
  EXPECT_TRUE(report.ok()) << report.errors.front();
}

TEST(MakeScene, LeavesOutWhatIsNotWanted) {
  const FinishedMap finished = RoomWithBox();
  const gltf::GltfScene plain = Scene(finished, {false, false, false, {}});
  EXPECT_TRUE(plain.objects[0].mesh.colours.empty());
  EXPECT_FALSE(plain.room.has_value());
  EXPECT_TRUE(plain.trajectory_world_from_camera.empty());
  EXPECT_TRUE(plain.keyframes.empty());
  EXPECT_TRUE(plain.ground.has_value());
}

TEST(MakeScene, AMeshInItsClassColourHasNoColoursOfItsOwn) {
  FinishedMap finished = RoomWithBox();
  std::ranges::fill(finished.meshes[0].colours, Rgb8{10, 20, 30});
  EXPECT_TRUE(Scene(finished).objects[0].mesh.colours.empty());
  finished.meshes[0].colours.back() = {10, 20, 31};
  EXPECT_FALSE(Scene(finished).objects[0].mesh.colours.empty());
}

TEST(MakeScene, GoesWithoutWhatWasNotSeen) {
  FinishedMap finished = RoomWithBox();
  finished.map.has_ground = false;
  finished.room_world = {};
  finished.meshes[0] = {};
  finished.map.map.objects[0].class_name = "unheard-of";
  const gltf::GltfScene scene = Scene(finished);
  EXPECT_FALSE(scene.ground.has_value());
  EXPECT_FALSE(scene.room.has_value());
  EXPECT_TRUE(scene.objects[0].mesh.empty());
  EXPECT_EQ(scene.objects[0].class_colour, (Rgb8{160, 160, 160}));
  EXPECT_TRUE(gltf::ValidateGlb(*gltf::WriteGlb(scene, {})).ok());
  EXPECT_TRUE(gltf::ValidateGlb(*gltf::WriteGlb(Scene({}), {})).ok());  // an empty map
}

TEST(RoomBeside, LeavesWallsAndTakesAwayWhatLiesOnObjectsAndGround) {
  const FinishedMap finished = RoomWithBox();
  const auto faces_where = [](const TriangleMesh& mesh, const auto& holds) {
    return std::ranges::count_if(mesh.faces, [&](const auto& face) {
      return std::ranges::all_of(
          face, [&](std::uint32_t corner) { return holds(mesh.vertices[corner]); });
    });
  };
  const auto on_wall = [](const Eigen::Vector3f& p) {
    return std::abs(p.y() - 3) < 1e-3F && p.z() > 0.1F;
  };
  const auto on_box = [](const Eigen::Vector3f& p) { return p.z() > 0.9F && p.y() < 1; };
  const auto on_floor = [](const Eigen::Vector3f& p) { return p.z() < 1e-3F; };
  const TriangleMesh beside =
      RoomBeside(finished.room_world, finished.map.map.objects, finished.meshes, std::nullopt);
  EXPECT_EQ(faces_where(beside, on_wall), faces_where(finished.room_world, on_wall));
  EXPECT_GT(faces_where(finished.room_world, on_box), 0);
  EXPECT_EQ(faces_where(beside, on_box), 0);
  EXPECT_GT(faces_where(beside, on_floor), 0);  // the measured floor stays where no ground is shown
  const TriangleMesh over_ground = RoomBeside(
      finished.room_world, finished.map.map.objects, finished.meshes, Scene(finished).ground);
  EXPECT_LT(faces_where(over_ground, on_floor), faces_where(beside, on_floor) / 10);
  EXPECT_EQ(faces_where(over_ground, on_wall), faces_where(finished.room_world, on_wall));
}

}  // namespace
}  // namespace deepslam::presentation
