#include "deepslam/presentation/compact_map.h"

#include <gmock/gmock.h>

#include "deepslam/artifact/map_json.h"
#include "deepslam/geometry/box.h"
#include "deepslam/gltf/validate.h"
#include "deepslam/presentation/expand_map.h"
#include "deepslam/presentation/labelled_scene.h"
#include "deepslam/presentation/map_rounding.h"
#include "deepslam/presentation/scene_check.h"
#include "presentation/room_with_box.h"
#include "support/layout_samples.h"

namespace deepslam::presentation {
namespace {

using testing::IsEmpty;

CompactMap MapOf(const FinishedMap& finished, const ShapeCodes& codes) {
  const gltf::GltfScene scene =
      MakeScene(finished, OneClass(), testing_support::SmallCamera(), SomeRun(), {});
  return MakeCompactMap(
      finished, scene, codes, {SomeRun(), {Verdict::kDoubtful, {"few keyframes"}}, {{"a", "b"}}});
}

TEST(MakeCompactMap, NotesTheRun) {
  const CompactMap map = MapOf(RoomWithBox(), CodesOfRoomWithBox());
  EXPECT_EQ(map.tool_version, "0.1.0");
  EXPECT_EQ(map.capture_name, "kitchen");
  EXPECT_EQ(map.capture_hash, "ab12");
  EXPECT_EQ(map.verdict, Verdict::kDoubtful);
  EXPECT_THAT(map.reasons, testing::ElementsAre("few keyframes"));
  EXPECT_EQ(map.mesh_options.at("a"), "b");
  EXPECT_TRUE(map.ground_world.has_value());
  EXPECT_EQ(map.class_colours.at("cabinet"), (Rgb8{10, 20, 30}));
}

// The map alone gives the scene's objects and ground back.
TEST(MakeCompactMap, IsEnoughToMakeTheSceneAgain) {
  const FinishedMap finished = RoomWithBox();
  const gltf::GltfScene scene =
      MakeScene(finished, OneClass(), testing_support::SmallCamera(), SomeRun(), {});
  const CompactMap map = MapOf(finished, CodesOfRoomWithBox());
  const Result<CompactMap> read =
      artifact::DecodeMap(*artifact::EncodeMap(map, "map.json"), "map.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  const Result<gltf::GltfScene> again = ExpandMap(*read, nullptr, {}, "0.1.0");
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_THAT(CompareWithMap(gltf::ValidateGlb(*gltf::WriteGlb(*again, {})), map), IsEmpty());
  EXPECT_THAT(CompareWithMap(gltf::ValidateGlb(*gltf::WriteGlb(scene, {})), map), IsEmpty());
  ASSERT_EQ(again->objects[0].mesh.faces, scene.objects[0].mesh.faces);
  // A metre wide, so that half a step of its scale is half a micrometre at its corners.
  for (std::size_t v = 0; v < scene.objects[0].mesh.vertices.size(); ++v) {
    ASSERT_LT((again->objects[0].mesh.vertices[v] - scene.objects[0].mesh.vertices[v]).norm(),
              kMapScaleStepM + 1e-6);
  }
}

TEST(MakeCompactMap, SaysWhereThingsAre) {
  FinishedMap finished = RoomWithBox();
  finished.map.map.objects[0].world_from_object.translation_m = {2, 0.52, 0.5};
  finished.layout_world = testing_support::TwoRoomLayout();
  const CompactMap map = MapOf(finished, CodesOfRoomWithBox());
  EXPECT_EQ(map.objects[0].room, 0);
  EXPECT_EQ(map.objects[0].against_wall, 0);
  EXPECT_EQ(map.objects[0].stands_on, kOnFloor);
  ASSERT_TRUE(map.layout.has_value());
  EXPECT_EQ(map.layout->walls.size(), 8U);
  finished.map.has_ground = false;  // heights then say nothing
  EXPECT_THAT(MapOf(finished, CodesOfRoomWithBox()).objects[0].stands_on, IsEmpty());
}

// 1.5 KB a room, with all its walls and openings.
TEST(MakeCompactMap, ALayoutIsSmall) {
  FinishedMap finished = RoomWithBox();
  const auto size = [&] {
    return artifact::EncodeMap(MapOf(finished, CodesOfRoomWithBox()), "map.json")->size();
  };
  const std::size_t without = size();
  finished.layout_world = testing_support::TwoRoomLayout();
  // Numbers as captures have them, with all their digits.
  for (LayoutWall& wall : finished.layout_world.walls) {
    wall.from_m += Eigen::Vector2d(0.1234567, -11.7654321);
    wall.to_m += Eigen::Vector2d(0.1234567, -11.7654321);
    wall.seen_share = wall.confidence = 0.8765432;
  }
  for (LayoutRoom& room : finished.layout_world.rooms) {
    for (Eigen::Vector2d& p : room.polygon_m) p += Eigen::Vector2d(0.1234567, -11.7654321);
  }
  EXPECT_LT(size() - without, 2 * 1500U);
}

TEST(MakeCompactMap, ExpandsToTheLayoutOfTheScene) {
  FinishedMap finished = RoomWithBox();
  finished.layout_world = testing_support::TwoRoomLayout();
  const CompactMap map = MapOf(finished, CodesOfRoomWithBox());
  const gltf::GltfScene scene =
      MakeScene(finished, OneClass(), testing_support::SmallCamera(), SomeRun(), {});
  const Result<gltf::GltfScene> again = ExpandMap(map, nullptr, {}, "0.1.0");
  ASSERT_TRUE(again.ok()) << again.error().message;
  ASSERT_EQ(again->parts.size(), scene.parts.size());
  for (std::size_t n = 0; n < scene.parts.size(); ++n) {
    EXPECT_EQ(again->parts[n].name, scene.parts[n].name);
    Box3 box;
    Box3 expanded;
    for (const Eigen::Vector3f& p : scene.parts[n].mesh_world.vertices)
      box.Extend(p.cast<double>());
    for (const Eigen::Vector3f& p : again->parts[n].mesh_world.vertices)
      expanded.Extend(p.cast<double>());
    EXPECT_LT((box.min - expanded.min).norm(), 2 * kMapLayoutStepM) << scene.parts[n].name;
    EXPECT_LT((box.max - expanded.max).norm(), 2 * kMapLayoutStepM) << scene.parts[n].name;
  }
  gltf::ValidationReport report = gltf::ValidateGlb(*gltf::WriteGlb(*again, {}));
  EXPECT_THAT(CompareWithMap(report, map), IsEmpty());
  report.parts.pop_back();
  report.parts.erase(report.parts.begin());
  EXPECT_THAT(CompareWithMap(report, map),
              testing::ElementsAre("walls: 7 in the scene, 8 in the map"));
}

TEST(MakeCompactMap, StoresEachShapeInItsWay) {
  FinishedMap finished = RoomWithBox();
  ShapeCodes codes = CodesOfRoomWithBox();
  const CompactShape own = MapOf(finished, codes).objects[0].shape;
  EXPECT_EQ(own.voxel_code, codes.models["fused_3"].voxel_code);
  EXPECT_THAT(own.library_id, IsEmpty());

  ShapeCandidate candidate;
  candidate.id = finished.map.map.objects[0].chosen;
  candidate.stretch = {1, 2, 1};
  candidate.latents = {0.5F};
  codes.candidates = {ShapeCandidate{}, candidate};
  codes.library_sha256["maker/box"] = std::string(64, 'c');
  finished.map.map.objects[0].library_id = "maker/box";
  const CompactShape cad = MapOf(finished, codes).objects[0].shape;
  EXPECT_EQ(cad.library_id, "maker/box");
  EXPECT_EQ(cad.library_checksum, std::string(kMapChecksumDigits, 'c'));
  EXPECT_EQ(cad.voxels_checksum,
            codes.models["fused_3"].voxels_sha256.substr(0, kMapChecksumDigits));
  EXPECT_EQ(cad.stretch.y(), 2);
  EXPECT_THAT(cad.latents, testing::ElementsAre(0.5F));
  EXPECT_THAT(cad.voxel_code, IsEmpty());

  finished.map.map.objects[0].library_id.clear();
  finished.meshes[0] = {};  // its surface could not be made
  EXPECT_THAT(MapOf(finished, codes).objects[0].shape.voxel_code, IsEmpty());
}

TEST(MakeCompactMap, ConfidenceLiesBetweenNoneAndCertainty) {
  FinishedMap finished = RoomWithBox();
  finished.map.map.objects[0].confidence = 1.0000001;
  EXPECT_EQ(MapOf(finished, CodesOfRoomWithBox()).objects[0].confidence, 1);
}

}  // namespace
}  // namespace deepslam::presentation
