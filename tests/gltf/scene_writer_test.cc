#include "deepslam/gltf/scene_writer.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "deepslam/gltf/validate.h"
#include "gltf/test_scene.h"

namespace deepslam::gltf {
namespace {

using Json = nlohmann::json;

Json NodeNamed(const Json& root, const std::string& name) {
  for (const Json& node : root["nodes"]) {
    if (node.value("name", "") == name) return node;
  }
  return {};
}

std::string AllErrors(const ValidationReport& report) {
  std::string text;
  for (const std::string& error : report.errors) text += error + "\n";
  return text;
}

TEST(WriteGlb, ScenePassesTheOwnCheckCompressedAndNot) {
  for (const bool draco : {true, false}) {
    GltfOptions options;
    options.draco = draco;
    const Result<std::string> glb = WriteGlb(SmallScene(), options);
    ASSERT_TRUE(glb.ok());
    const ValidationReport report = ValidateGlb(*glb);
    EXPECT_TRUE(report.ok()) << AllErrors(report);
    EXPECT_TRUE(report.warnings.empty()) << report.warnings.front();
    EXPECT_EQ(report.draco, draco);
    EXPECT_EQ(report.num_objects, 3);
    EXPECT_TRUE(report.has_ground && report.has_room && report.has_trajectory);
    EXPECT_EQ(report.num_faces, 3 * 12 + 2 + 2);
    for (const ValidatedObject& object : report.objects) {
      EXPECT_TRUE(object.closed && object.two_manifold);
      EXPECT_EQ(object.num_vertices, 8);
      EXPECT_NEAR(object.volume_m3, 0.6 * 0.4 * 0.9, 1e-4);  // metric
    }
  }
}

TEST(WriteGlbs, FilesAreThoseWrittenOneByOne) {
  GltfScene scene = SmallScene();
  scene.objects.push_back(scene.objects[0]);
  scene.objects[0].model = scene.objects[3].model = "m";
  GltfScene objects_alone;
  objects_alone.objects = scene.objects;
  objects_alone.provenance = scene.provenance;
  const std::vector<GlbKind> kinds = {{true, false}, {true, true}, {false, false}};
  const std::vector<Result<std::string>> files = WriteGlbs(scene, {}, kinds);
  ASSERT_EQ(files.size(), kinds.size());
  EXPECT_EQ(*files[0], *WriteGlb(scene, {}));
  EXPECT_EQ(*files[1], *WriteGlb(objects_alone, {}));
  EXPECT_EQ(*files[2], *WriteGlb(scene, Plain()));

  scene.room->vertices[0].x() = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Result<std::string>> faulty = WriteGlbs(scene, {}, kinds);
  EXPECT_EQ(faulty[0].error().message, WriteGlb(scene, {}).error().message);
  EXPECT_EQ(*faulty[1], *files[1]);
  EXPECT_FALSE(faulty[2].ok());
}

TEST(WriteGlb, LabelsStandInCoreGltf) {
  const Json root = Json::parse(JsonOf(*WriteGlb(SmallScene(), {})));
  const Json chair = NodeNamed(root, "chair_02");
  EXPECT_EQ(chair["extras"]["class"], "chair");
  EXPECT_EQ(chair["extras"]["instance"], 2);
  EXPECT_EQ(chair["extras"]["prior"], "retrieval");
  EXPECT_EQ(chair["extras"]["views"], Json({3, 14, 15}));
  EXPECT_DOUBLE_EQ(chair["extras"]["score"].get<double>(), 0.75);
  EXPECT_EQ(root["asset"]["extras"]["credits"], Json::array({"A. Maker, CC-BY 3.0"}));
  EXPECT_EQ(root["asset"]["extras"]["capture"], "00ff");
  EXPECT_EQ(root["extensionsRequired"], Json::array({"KHR_draco_mesh_compression"}));
  GltfScene plain = SmallScene();
  plain.objects[1].mesh.colours.clear();
  EXPECT_FALSE(Json::parse(JsonOf(*WriteGlb(plain, Plain()))).contains("extensionsUsed"));
}

TEST(WriteGlb, ColouredObjectsSwitchToTheirClassColour) {
  for (const bool draco : {true, false}) {
    GltfOptions options;
    options.draco = draco;
    const Result<std::string> glb = WriteGlb(SmallScene(), options);
    const Json root = Json::parse(JsonOf(*glb));
    const Json variants = root["extensions"]["KHR_materials_variants"]["variants"];
    ASSERT_EQ(variants, Json::array({{{"name", "appearance"}}, {{"name", "class"}}}));
    EXPECT_EQ(ValidateGlb(*glb).variants, (std::vector<std::string>{"appearance", "class"}));
    const Json primitive =
        root["meshes"][NodeNamed(root, "chair_02")["mesh"].get<std::size_t>()]["primitives"][0];
    const Json mappings = primitive["extensions"]["KHR_materials_variants"]["mappings"];
    ASSERT_EQ(mappings.size(), 2U);
    EXPECT_EQ(mappings[0]["material"], primitive["material"]);  // what shows without the extension
    const Json flat = root["materials"][mappings[1]["material"].get<std::size_t>()];
    const auto glow = flat["emissiveFactor"].get<std::vector<double>>();
    EXPECT_NEAR(glow[0], std::pow((200 / 255.0 + 0.055) / 1.055, 2.4), 1e-4);  // sRGB 200
    // Nobody needs the extension to read the file.
    EXPECT_EQ(root.value("extensionsRequired", Json::array()),
              draco ? Json::array({"KHR_draco_mesh_compression"}) : Json::array());
  }
}

TEST(WriteGlb, ObjectsOfOneModelShareAMeshWhateverTheirSize) {
  for (const bool draco : {true, false}) {
    GltfOptions options;
    options.draco = draco;
    GltfScene scene;
    for (int n = 1; n <= 4; ++n) {
      GltfObject object = BoxObject("chair", n);
      object.model = "maker__chair";
      object.scale_m = 0.5 + 0.1 * n;
      for (Eigen::Vector3f& p : object.mesh.vertices) p *= static_cast<float>(object.scale_m);
      scene.objects.push_back(std::move(object));
    }
    scene.objects[2].model = "maker__other";
    scene.objects[3].mesh.vertices[0].x() -= 0.01F;  // says it is that model, but is not
    const Result<std::string> glb = WriteGlb(scene, options);
    ASSERT_TRUE(glb.ok());
    const Json root = Json::parse(JsonOf(*glb));
    EXPECT_EQ(root["meshes"].size(), 3U);
    EXPECT_EQ(NodeNamed(root, "chair_01")["mesh"], NodeNamed(root, "chair_02")["mesh"]);
    const ValidationReport report = ValidateGlb(*glb);
    ASSERT_TRUE(report.ok()) << AllErrors(report);
    for (std::size_t n = 0; n < 3; ++n) {  // each as large as it is
      const double scale = scene.objects[n].scale_m;
      EXPECT_NEAR(report.objects[n].volume_m3, 0.6 * 0.4 * 0.9 * scale * scale * scale, 1e-4);
    }
  }
}

// Where a point of a node lies in glTF's world.
Eigen::Vector3d InGltfWorld(const Json& node, const Eigen::Vector3d& p) {
  const auto t = node["translation"].get<std::vector<double>>();
  const auto r = node["rotation"].get<std::vector<double>>();
  return Eigen::Quaterniond(r[3], r[0], r[1], r[2]) * p + Eigen::Vector3d(t[0], t[1], t[2]);
}

TEST(WriteGlb, OpensUprightWithFrontAndLeftWhereGltfHasThem) {
  GltfScene scene = SmallScene();
  const Pose3 pose{Eigen::Quaterniond(Eigen::Vector4d(0.1, -0.3, 0.5, 0.8).normalized()),
                   {1, 2, 3}};
  scene.objects[0].world_from_object = pose;
  const Json node = NodeNamed(Json::parse(JsonOf(*WriteGlb(scene, {}))), "chair_01");
  const auto to_gltf = [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.y(), p.z(), p.x());  // left = +x, up = +y, front = +z
  };
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0.2, 0.3, 0.4)}) {
    EXPECT_LT((InGltfWorld(node, to_gltf(p)) - to_gltf(pose * p)).norm(), 1e-9);
  }
}

TEST(WriteGlb, KeyframeCamerasLookWhereTheSensorLooked) {
  GltfScene scene = SmallScene();
  const Pose3 pose{Eigen::Quaterniond(Eigen::Vector4d(0.4, -0.3, 0.1, 0.8).normalized()),
                   {1, 2, 3}};
  scene.keyframes = {{17, pose}};
  const Json root = Json::parse(JsonOf(*WriteGlb(scene, {})));
  const Json node = NodeNamed(root, "keyframe_000017");
  const auto to_gltf = [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.y(), p.z(), p.x());
  };
  // A point one metre ahead lies at -z of glTF's camera, one to the right at +x, one below at -y.
  EXPECT_LT((InGltfWorld(node, {0, 0, -1}) - to_gltf(pose * Eigen::Vector3d(0, 0, 1))).norm(),
            1e-9);
  EXPECT_LT((InGltfWorld(node, {1, 0, 0}) - to_gltf(pose * Eigen::Vector3d(1, 0, 0))).norm(), 1e-9);
  EXPECT_LT((InGltfWorld(node, {0, -1, 0}) - to_gltf(pose * Eigen::Vector3d(0, 1, 0))).norm(),
            1e-9);
  EXPECT_NEAR(
      root["cameras"][0]["perspective"]["yfov"].get<double>(), 2 * std::atan(240.0 / 525), 1e-9);
}

TEST(WriteGlb, GivesTheSameBytesTwice) {
  EXPECT_EQ(*WriteGlb(SmallScene(), {}), *WriteGlb(SmallScene(), {}));
  EXPECT_EQ(*WriteGlb(SmallScene(), Plain()), *WriteGlb(SmallScene(), Plain()));
}

TEST(WriteGlb, EmptyScenesAndEmptyMeshesAreValid) {
  for (const bool draco : {true, false}) {
    GltfOptions options;
    options.draco = draco;
    EXPECT_TRUE(ValidateGlb(*WriteGlb({}, options)).ok());
    GltfScene scene = SmallScene();
    scene.objects.resize(1);
    scene.objects[0].mesh = {};
    scene.room = TriangleMesh();
    const ValidationReport report = ValidateGlb(*WriteGlb(scene, options));
    EXPECT_TRUE(report.ok()) << AllErrors(report);
    EXPECT_EQ(report.num_objects, 1);
    EXPECT_FALSE(report.has_room);
  }
}

TEST(WriteGlb, TakesAnyNames) {
  GltfScene scene = SmallScene();
  scene.objects[0].name = "стул \xF0\x9F\xAA\x91";
  scene.objects[1].name = std::string("\xFF\xC0\x80 \xED\xA0\x80\0\n\"\\", 12);
  scene.objects[2].name = scene.objects[0].name;
  scene.objects.push_back(BoxObject("room", 1));
  scene.objects.back().name = "room";
  scene.provenance["\xFE"] = "\xFE";
  scene.objects[0].credit = "\xE9";
  const Result<std::string> glb = WriteGlb(scene, {});
  ASSERT_TRUE(glb.ok()) << glb.error().message;
  const ValidationReport report = ValidateGlb(*glb);
  EXPECT_TRUE(report.ok()) << AllErrors(report);
  EXPECT_EQ(report.objects[0].name, "стул \xF0\x9F\xAA\x91");
  EXPECT_EQ(report.objects[2].name, "стул \xF0\x9F\xAA\x91_2");
}

TEST(WriteGlb, NamesTheObjectThatIsWrong) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  GltfScene index = SmallScene();
  index.objects[1].mesh.faces[3][1] = 88;
  GltfScene nan = SmallScene();
  nan.objects[1].mesh.vertices[0].x() = static_cast<float>(kNan);
  GltfScene pose = SmallScene();
  pose.objects[1].world_from_object.translation_m.x() = kNan;
  GltfScene colours = SmallScene();
  colours.objects[1].mesh.colours.pop_back();
  GltfScene score = SmallScene();
  score.objects[1].score = kNan;
  for (const GltfScene& scene : {index, nan, pose, colours, score}) {
    const Result<std::string> glb = WriteGlb(scene, {});
    ASSERT_FALSE(glb.ok());
    EXPECT_NE(glb.error().message.find("chair_02"), std::string::npos) << glb.error().message;
  }
}

TEST(WriteGlb, WritesAThousandObjects) {
  GltfScene scene;
  for (int n = 0; n < 1000; ++n) scene.objects.push_back(BoxObject("chair", n));
  const ValidationReport report = ValidateGlb(*WriteGlb(scene, {}));
  EXPECT_TRUE(report.ok()) << AllErrors(report);
  EXPECT_EQ(report.num_objects, 1000);
}

}  // namespace
}  // namespace deepslam::gltf
