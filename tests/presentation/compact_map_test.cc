#include "deepslam/presentation/compact_map.h"

#include <gmock/gmock.h>

#include "deepslam/artifact/map_json.h"
#include "deepslam/gltf/validate.h"
#include "deepslam/presentation/expand_map.h"
#include "deepslam/presentation/labelled_scene.h"
#include "deepslam/presentation/map_rounding.h"
#include "deepslam/presentation/scene_check.h"
#include "presentation/room_with_box.h"

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
