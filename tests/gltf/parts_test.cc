// Parts of the room itself in scenes.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "deepslam/gltf/validate.h"
#include "gltf/test_scene.h"

namespace deepslam::gltf {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

GltfPart Wall(int id) {
  GltfPart part;
  part.name = "wall_0" + std::to_string(id);
  part.kind = "wall";
  part.id = id;
  part.rooms = {0, 1};
  part.figures = {{"length_m", 4.25}};
  part.mesh_world = BoxMesh(2, 0.05F, 2.5F);
  return part;
}

GltfScene WithParts() {
  GltfScene scene = SmallScene();
  scene.parts = {Wall(0), Wall(1), Wall(0)};
  scene.parts[2].name = "door_00";
  scene.parts[2].kind = "door";
  scene.parts[2].wall = 1;
  scene.parts[2].mesh_world = {};
  scene.parts[1].opacity = 0.25;
  return scene;
}

TEST(GltfParts, AreNodesWithExtrasThatAreNoObjects) {
  const std::string glb = *WriteGlb(WithParts(), {});
  const ValidationReport report = ValidateGlb(glb);
  EXPECT_THAT(report.errors, IsEmpty());
  EXPECT_EQ(report.num_objects, 3);
  ASSERT_EQ(report.parts.size(), 3U);
  EXPECT_EQ(report.parts[1].name, "wall_01");
  EXPECT_EQ(report.parts[1].kind, "wall");
  EXPECT_EQ(report.parts[1].id, 1);
  EXPECT_TRUE(report.parts[1].has_mesh);
  EXPECT_FALSE(report.parts[2].has_mesh);
  const nlohmann::json root = nlohmann::json::parse(JsonOf(glb));
  for (const auto& node : root.at("nodes")) {
    if (node.at("name") == "wall_00") {
      EXPECT_EQ(node.at("extras").at("length_m"), 4.25);
      EXPECT_EQ(node.at("extras").at("rooms"), nlohmann::json({0, 1}));
    }
    if (node.at("name") == "door_00") {
      EXPECT_EQ(node.at("extras").at("wall"), 1);
    }
  }
  int num_blended = 0;
  for (const auto& material : root.at("materials"))
    num_blended += material.value("alphaMode", "OPAQUE") == "BLEND" ? 1 : 0;
  EXPECT_EQ(num_blended, 1);
}

TEST(GltfParts, NamesAreUniqueBesideThoseOfObjects) {
  GltfScene scene = WithParts();
  scene.objects[0].name = "wall_00";
  scene.objects[0].class_name = "wall";
  const ValidationReport report = ValidateGlb(*WriteGlb(scene, {}));
  EXPECT_THAT(report.errors, IsEmpty());
  EXPECT_EQ(report.objects[0].name, "wall_00");
  EXPECT_EQ(report.parts[0].name, "wall_00_2");
}

TEST(GltfParts, ThatAreOpenOrNamedTwiceAreFaults) {
  GltfScene open = WithParts();
  open.parts[0].mesh_world.faces.pop_back();
  const ValidationReport of_open = ValidateGlb(*WriteGlb(open, {}));
  ASSERT_FALSE(of_open.ok());
  EXPECT_THAT(of_open.errors[0], HasSubstr("wall_00"));
  GltfScene twice = WithParts();
  twice.parts[1].id = 0;
  const ValidationReport of_twice = ValidateGlb(*WriteGlb(twice, {}));
  ASSERT_FALSE(of_twice.ok());
  EXPECT_THAT(of_twice.errors[0], HasSubstr("not unique"));
}

TEST(GltfParts, WithBadIndicesAreRefusedByName) {
  GltfScene scene = WithParts();
  scene.parts[1].mesh_world.faces[0][0] = 999;
  const Result<std::string> glb = WriteGlb(scene, {});
  ASSERT_FALSE(glb.ok());
  EXPECT_THAT(glb.error().message, HasSubstr("wall_01"));
}

}  // namespace
}  // namespace deepslam::gltf
