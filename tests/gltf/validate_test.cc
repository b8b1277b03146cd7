#include "deepslam/gltf/validate.h"

#include <functional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "deepslam/core/random.h"
#include "gltf/test_scene.h"

namespace deepslam::gltf {
namespace {

using Json = nlohmann::json;

std::string TinyGlb(bool draco) {
  GltfScene scene;
  scene.objects = {BoxObject("chair", 1)};
  GltfOptions options;
  options.draco = draco;
  return *WriteGlb(scene, options);
}

TEST(ValidateGlb, FindsEveryTruncation) {
  for (const bool draco : {true, false}) {
    const std::string glb = TinyGlb(draco);
    for (std::size_t n = 0; n < glb.size(); ++n) {
      EXPECT_FALSE(ValidateGlb(std::string_view(glb).substr(0, n)).ok()) << n;
    }
  }
}

TEST(ValidateGlb, SurvivesTruncationBehindATrueHeader) {
  const std::string glb = TinyGlb(true);
  for (std::size_t n = 20; n < glb.size(); n += 4) {
    std::string cut = glb.substr(0, n);
    const auto size = static_cast<std::uint32_t>(n);
    std::memcpy(cut.data() + 8, &size, 4);
    EXPECT_FALSE(ValidateGlb(cut).ok()) << n;
  }
}

TEST(ValidateGlb, SurvivesFlippedBytes) {
  for (const bool draco : {true, false}) {
    const std::string glb = TinyGlb(draco);
    Random random(11);
    for (int n = 0; n < 1500; ++n) {
      std::string damaged = glb;
      for (std::uint64_t flips = 1 + random.Index(3); flips > 0; --flips) {
        damaged[random.Index(damaged.size())] = static_cast<char>(random.Next());
      }
      const ValidationReport report = ValidateGlb(damaged);
      EXPECT_LE(report.errors.size(), kMaxFindings);
    }
  }
}

struct Damage {
  const char* name;
  const char* place;  // must stand in an error
  bool draco;
  std::function<void(Json&)> apply;
};

class ValidateGlbFinds : public ::testing::TestWithParam<Damage> {};

TEST_P(ValidateGlbFinds, TheDamageAndNamesThePlace) {
  const std::string glb = *WriteGlb(SmallScene(), GetParam().draco ? GltfOptions() : Plain());
  Json root = Json::parse(JsonOf(glb));
  GetParam().apply(root);
  const ValidationReport report = ValidateGlb(WithJson(glb, root.dump()));
  ASSERT_FALSE(report.ok());
  bool named = false;
  for (const std::string& error : report.errors) {
    named |= error.find(GetParam().place) != std::string::npos;
  }
  EXPECT_TRUE(named) << report.errors.front();
}

INSTANTIATE_TEST_SUITE_P(
    All,
    ValidateGlbFinds,
    ::testing::Values(
        Damage{"HugeCount",
               "accessors[0].count",
               false,
               [](Json& j) { j["accessors"][0]["count"] = 4000000000000000000ULL; }},
        Damage{"NegativeCount",
               "accessors[0].count",
               false,
               [](Json& j) { j["accessors"][0]["count"] = -1; }},
        Damage{"CountOffByOne",
               "accessors[0].count",
               false,
               [](Json& j) {
                 j["accessors"][0]["count"] = j["accessors"][0]["count"].get<int>() + 1;
               }},
        Damage{"DracoCount",
               "draco",
               true,
               [](Json& j) {
                 j["accessors"][0]["count"] = 7;
                 j["accessors"][1]["count"] = 7;
               }},
        Damage{"HugeDracoCount",
               "draco",
               true,
               [](Json& j) {
                 j["accessors"][0]["count"] = 4000000000U;
                 j["accessors"][1]["count"] = 4000000000U;
               }},
        Damage{"ViewPastEnd",
               "bufferViews[1]",
               false,
               [](Json& j) { j["bufferViews"][1]["byteOffset"] = 18446744073709551615ULL; }},
        Damage{"Unaligned",
               "accessors",
               false,
               [](Json& j) {
                 j["bufferViews"][1]["byteOffset"] =
                     j["bufferViews"][1]["byteOffset"].get<int>() - 1;
               }},
        Damage{"WrongMax", "POSITION", false, [](Json& j) { j["accessors"][0]["max"][1] = 77.0; }},
        Damage{
            "WrongMaxDraco", "POSITION", true, [](Json& j) { j["accessors"][0]["max"][1] = 77.0; }},
        Damage{"NoMin", "POSITION", false, [](Json& j) { j["accessors"][0].erase("min"); }},
        Damage{"MeshIndex", "nodes[0].mesh", true, [](Json& j) { j["nodes"][0]["mesh"] = 99; }},
        Damage{"NotUnit",
               "nodes[0].rotation",
               true,
               [](Json& j) {
                 j["nodes"][0]["rotation"] = {1, 1, 1, 1};
               }},
        Damage{"NullTranslation",
               "nodes[0].translation",
               true,
               [](Json& j) {
                 j["nodes"][0]["translation"] = {nullptr, 0, 0};
               }},
        Damage{"Cycle",
               "nodes",
               true,
               [](Json& j) {
                 j["nodes"][0]["children"] = {1};
                 j["nodes"][1]["children"] = {0};
               }},
        Damage{"ManyParents",
               "nodes[0]",
               true,
               [](Json& j) {
                 j["nodes"][1]["children"] = {0};
                 j["nodes"][2]["children"] = {0};
               }},
        Damage{"SameInstance",
               "nodes[1]",
               true,
               [](Json& j) { j["nodes"][1]["extras"]["instance"] = 1; }},
        Damage{"SameName", "nodes[1]", true, [](Json& j) { j["nodes"][1]["name"] = "chair_01"; }},
        Damage{"NoInstance",
               "nodes[1]",
               true,
               [](Json& j) { j["nodes"][1]["extras"].erase("instance"); }},
        Damage{"OpenObject",
               "nodes[0]",
               false,
               [](Json& j) {
                 const int indices = j["meshes"][0]["primitives"][0]["indices"];
                 j["accessors"][indices]["count"] = 33;
               }},
        Damage{"UnknownExtension",
               "extensionsRequired",
               false,
               [](Json& j) { j["extensionsRequired"] = {"EXT_meshopt_compression"}; }},
        Damage{"DracoView",
               "bufferView",
               true,
               [](Json& j) {
                 j["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
                  ["bufferView"] = 1000;
               }},
        Damage{"DracoId",
               "draco",
               true,
               [](Json& j) {
                 j["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
                  ["attributes"]["POSITION"] = 55;
               }},
        Damage{"DracoIdOfColours",
               "draco",
               true,
               [](Json& j) {
                 j["meshes"][1]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
                  ["attributes"]["COLOR_0"] = 55;
               }},
        Damage{"VariantIndex",
               "mappings[1].variants",
               true,
               [](Json& j) {
                 j["meshes"][1]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"]
                  [1]["variants"][0] = 2;
               }},
        Damage{"VariantTwice",
               "mappings[1].variants",
               true,
               [](Json& j) {
                 j["meshes"][1]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"]
                  [1]["variants"][0] = 0;
               }},
        Damage{"VariantMaterial",
               "mappings[0].material",
               true,
               [](Json& j) {
                 j["meshes"][1]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"]
                  [0]["material"] = 99;
               }},
        Damage{
            "VariantsAreNone",
            "KHR_materials_variants.variants",
            true,
            [](Json& j) { j["extensions"]["KHR_materials_variants"]["variants"] = Json::array(); }},
        Damage{"Version", "asset.version", true, [](Json& j) { j["asset"]["version"] = "1.0"; }},
        Damage{"ListIsNumber", "nodes", true, [](Json& j) { j["nodes"] = 5; }},
        Damage{"NodeIsNumber", "nodes[0]", true, [](Json& j) { j["nodes"][0] = 5; }}),
    [](const auto& damage) { return std::string(damage.param.name); });

TEST(ValidateGlb, RefusesForeignFiles) {
  EXPECT_FALSE(ValidateGlb("").ok());
  EXPECT_FALSE(ValidateGlb("\x89PNG\r\n\x1a\n and more of a picture ....").ok());
  EXPECT_FALSE(ValidateGlb(WithJson(TinyGlb(true), "not json")).ok());
  EXPECT_FALSE(ValidateGlb(WithJson(TinyGlb(true), "[]")).ok());
  EXPECT_FALSE(ValidateGlb(WithJson(TinyGlb(true), std::string(200000, '['))).ok());
  EXPECT_FALSE(ValidateGlb(WithJson(TinyGlb(true), "{}")).ok());
}

}  // namespace
}  // namespace deepslam::gltf
